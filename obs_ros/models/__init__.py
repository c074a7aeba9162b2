"""The built-in plants, by name."""

from obs_ros.core.model import Model
from obs_ros.core.registry import lookup

MODELS = {
    'glycolytic_oscillator': 'obs_ros.models.glycolytic_oscillator:GLYCOLYTIC_OSCILLATOR',
    'heat_exchanger': 'obs_ros.models.heat_exchanger:HEAT_EXCHANGER',
    'heat_exchanger_reduced': 'obs_ros.models.heat_exchanger:HEAT_EXCHANGER_REDUCED',
    'jet_engine': 'obs_ros.models.jet_engine:JET_ENGINE',
    'linear_second_order': 'obs_ros.models.linear_second_order:LINEAR_SECOND_ORDER',
    'observer_form_third_order': (
        'obs_ros.models.observer_form_third_order:OBSERVER_FORM_THIRD_ORDER'
    ),
    'observer_form_third_order_nmp': (
        'obs_ros.models.observer_form_third_order:OBSERVER_FORM_THIRD_ORDER_NMP'
    ),
    'suspension': 'obs_ros.models.suspension:SUSPENSION',
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
