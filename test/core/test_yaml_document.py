"""Tests of obs_ros.core.yaml_document."""

import pytest
import yaml

from obs_ros.core.yaml_document import document


def test_a_loader_reads_its_one_document_and_is_done_with() -> None:
    assert document(yaml.SafeLoader('a: [1, 2]')) == {'a': [1, 2]}
    with pytest.raises(yaml.YAMLError):
        document(yaml.SafeLoader('a: 1\n---\nb: 2'))


@pytest.mark.parametrize('text', ['a: 1', 'a: ['])
def test_it_is_disposed_of_whatever_the_text(text: str) -> None:
    disposed = []

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        def dispose(self) -> None:
            disposed.append(self)

    try:
        document(Loader(text))
    except yaml.YAMLError:
        assert text == 'a: ['
    assert len(disposed) == 1
