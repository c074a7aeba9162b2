"""The built-in plants, by name."""

from obs_ros.model import Model
from obs_ros.registry import lookup

MODELS = {
    'three_tank': 'obs_ros.models.three_tank:THREE_TANK',
}


def load_model(model: Model | str) -> Model:
    """Return the model of that name, or at that `module:ATTRIBUTE`; a Model is returned as it is.

    Raises ValueError when there is none, or what stands there is not a Model.
    """
    if isinstance(model, Model):
        return model
    found = lookup('model', model, MODELS)
    if not isinstance(found, Model):
        raise ValueError(f'model {model!r} is a {type(found).__name__}, not an obs_ros.Model')
    return found
