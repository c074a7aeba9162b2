"""Words for parameters that drift: with a walk of their own they need no jumps."""

from collections.abc import Sequence


def remedy(drifting: Sequence[str]) -> str:
    """Return what to do about parameters that move too often to have jumped; '' about none."""
    if not drifting:
        return ''
    them, move = ('it a walk', 'moves') if len(drifting) == 1 else ('them walks', 'move')
    walks = ', '.join(f'walk.{name}' for name in drifting)
    return f'give {them}: {walks} ({", ".join(drifting)} {move} too often to have jumped)'
