from obs_ros.studies.store import Store


def test_a_result_is_found_by_its_key_and_by_no_other(tmp_path):
    store = Store(tmp_path / 'results')
    assert store.get('a') is None
    store.put('a', b'result')
    assert (store.get('a'), store.get('b')) == (b'result', None)
    assert Store(tmp_path / 'results').get('a') == b'result'
    store.put('a', b'another')
    assert store.get('a') == b'another'
    assert [path.name for path in store.folder.iterdir()] == ['a.result']  # no drafts


def test_a_damaged_file_counts_as_missing(tmp_path):
    store = Store(tmp_path)
    store.put('a', b'result')
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for broken in (whole[:-1], b'', whole[:-1] + b'x'):
        file.write_bytes(broken)
        assert store.get('a') is None


def test_only_results_are_forgotten(tmp_path):
    store = Store(tmp_path)
    store.put('a', b'result')
    (tmp_path / 'notes.txt').write_text('mine')
    store.forget()
    assert [path.name for path in tmp_path.iterdir()] == ['notes.txt']
