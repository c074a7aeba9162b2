"""The parameters of the live page's node, and its `--help`."""

from collections.abc import Sequence

from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.interface.usage import node_usage

ALL = 'all'
VIEW = (
    ParameterSpec('host', '127.0.0.1',
        'address to listen on: whoever reaches it sees all estimates, unencrypted', read_only=True),
    # Foxglove's bridge listens on 8765, Dask's dashboard on 8787, Jupyter on 8888.
    ParameterSpec('port', 8770, 'port to listen on; 0: any that is free',
        lower=0, upper=65535, read_only=True),
    ParameterSpec('estimators', (ALL,),
        f"full names of the estimators to show, such as /line1/estimator; ['{ALL}']: the first 16 "
        'that are found', read_only=True),
)  # fmt: skip


def wanted(estimators: Sequence[str], name: str) -> bool:
    """Whether an estimator of that name is to be shown."""
    return tuple(estimators) == (ALL,) or name in estimators


def usage() -> str:
    """Return what `view --help` prints."""
    return node_usage(
        'view',
        'Serves a page that shows, live, what estimators estimate: open the address that it '
        'prints in a browser. It reads topics only.',
        VIEW,
        {},
        ('What one sees: docs/view.md.',),
    )
