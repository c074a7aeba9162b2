"""The server: who may ask, what for, and what is answered."""

import http.client
import json
import socket
import threading

import pytest
from patience import patience

from obs_ros.pages import server
from obs_ros.pages.server import SETTINGS, PageServer

POLICY = "default-src 'none'; script-src 'sha256-x'"


def answer(query):
    if 'wrong' in query:
        raise ValueError('ask otherwise\nplease')
    if 'broken' in query:
        raise KeyError('a defect')
    return {'asked': query}


@pytest.fixture
def served():
    served = PageServer('127.0.0.1', 0, '<p>page</p>', POLICY, answer)
    yield served
    served.close()


def ask(served, path='/', method='GET', host=None, **headers):
    connection = http.client.HTTPConnection('127.0.0.1', served.port, timeout=patience(5.0))
    connection.putrequest(method, path, skip_host=True)
    host = f'127.0.0.1:{served.port}' if host is None else host
    for name, value in {'Host': host, **headers}.items():
        connection.putheader(name, value)
    connection.endheaders()
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response, body


def test_it_listens_on_the_loopback_only(served):
    assert served._server.server_address[0] == '127.0.0.1'
    assert served.port > 0 and served.address == f'http://127.0.0.1:{served.port}/'


def test_the_page_comes_with_its_policy(served):
    response, body = ask(served)
    assert (response.status, body) == (200, b'<p>page</p>')
    assert response.headers['Content-Security-Policy'] == POLICY
    assert response.headers['Content-Type'] == 'text/html; charset=utf-8'


@pytest.mark.parametrize('path', ['/', '/data', '/data?wrong=1', '/no', '/../etc/passwd'])
def test_every_answer_has_the_headers_that_guard_it(served, path):
    headers = ask(served, path)[0].headers
    assert headers['X-Content-Type-Options'] == 'nosniff'
    assert headers['X-Frame-Options'] == 'DENY'
    assert headers['Cross-Origin-Resource-Policy'] == 'same-origin'
    assert headers['Cache-Control'] == 'no-store'
    assert headers['Content-Security-Policy'].startswith("default-src 'none'")
    assert headers['Server'].strip() == 'obs_ros'
    assert 'Access-Control-Allow-Origin' not in headers


def test_data_are_json(served):
    response, body = ask(served, '/data?of=%2Fa%2Festimator&of=b&from=1')
    assert response.headers['Content-Type'] == 'application/json'
    assert json.loads(body) == {'asked': {'of': ['/a/estimator', 'b'], 'from': ['1']}}


@pytest.mark.parametrize(
    ('path', 'status', 'words'),
    [
        ('/data?wrong=1', 400, b'ask otherwise please\n'),
        ('/data?' + 'a=1&' * 50, 400, b'Max number of fields exceeded\n'),
        ('/data?broken=1', 500, b"'a defect'"),
        ('/secret', 404, b'there is / and /data\n'),
        ('/data/', 404, b'there is'),
        ('/' + 'x' * 5000, 414, b'ask for less'),
    ],
    ids=['wrong', 'many fields', 'defect', 'unknown', 'below', 'long'],
)
def test_what_cannot_be_answered_is_said(served, path, status, words):
    response, body = ask(served, path)
    assert response.status == status and words in body
    assert response.headers['Content-Type'].startswith('text/plain')


@pytest.mark.parametrize('method', ['POST', 'PUT', 'DELETE', 'OPTIONS', 'TRACE', 'BREW'])
def test_nothing_can_be_changed(served, method):
    response, body = ask(served, '/data', method)
    assert response.status == 501 and b'BREW' not in body


def test_head_has_no_body(served):
    response, body = ask(served, '/', 'HEAD')
    assert response.status == 200 and body == b''


@pytest.mark.parametrize(
    ('host', 'status'),
    [
        ('127.0.0.1:{port}', 200), ('localhost:{port}', 200), ('LOCALHOST:{port}', 200),
        ('127.0.0.1', 200), ('[::1]:{port}', 200), ('127.8.8.8:{port}', 200),
        ('evil.example', 421), ('evil.example:{port}', 421), ('localhost.evil.example', 421),
        ('127.0.0.1.evil.example:{port}', 421), ('127.0.0.1:1', 421), ('', 421),
        ('10.0.0.1:{port}', 421), ('[::1', 200), ('localhost:{port}:x', 421),
    ],
)  # fmt: skip
@pytest.mark.parametrize('path', ['/', '/data'])
def test_only_requests_that_name_this_machine_are_answered(served, host, status, path):
    """A name that is made to lead here (DNS rebinding) stands in the Host of what it asks."""
    response, body = ask(served, path, host=host.format(port=served.port))
    assert response.status == status
    assert status == 200 or (b'page' not in body and b'asked' not in body)


def test_open_to_the_network_it_takes_numbers_and_its_own_name():
    served = PageServer('0.0.0.0', 0, 'page', POLICY, answer)
    try:
        assert socket.gethostname() in served.address
        for host, status in (('10.0.0.1', 200), (socket.gethostname(), 200), ('evil.example', 421)):
            assert ask(served, host=f'{host}:{served.port}')[0].status == status
    finally:
        served.close()


def test_a_port_that_is_taken_is_an_error(served):
    with pytest.raises(OSError):
        PageServer('127.0.0.1', served.port, 'page', POLICY, answer)


def test_requests_at_once_are_bounded():
    """More than `most` are closed unheard, and room comes back when others end."""
    begun, go_on = threading.Semaphore(0), threading.Event()

    def slow(query):
        begun.release()
        go_on.wait(patience(10.0))
        return {}

    served = PageServer('127.0.0.1', 0, 'page', POLICY, slow)
    asking = [threading.Thread(target=ask, args=(served, '/data')) for _ in range(SETTINGS.most)]
    try:
        for each in asking:
            each.start()
        assert all(begun.acquire(timeout=patience(10.0)) for _ in asking)
        with pytest.raises((http.client.HTTPException, ConnectionError)):
            ask(served)
        go_on.set()
        for each in asking:
            each.join()
        assert ask(served)[0].status == 200
    finally:
        go_on.set()
        served.close()


def test_a_machine_that_has_no_more_threads_for_a_while_costs_no_room(monkeypatch):
    def none(thread):
        raise RuntimeError("can't start new thread")

    served = PageServer('127.0.0.1', 0, 'page', POLICY, answer)
    try:
        with monkeypatch.context() as patch:
            patch.setattr(threading.Thread, 'start', none)
            for _ in range(SETTINGS.most):
                with pytest.raises((http.client.HTTPException, ConnectionError)):
                    ask(served)
        assert ask(served)[0].status == 200
    finally:
        served.close()


def test_a_connection_that_says_nothing_is_closed(monkeypatch):
    monkeypatch.setattr(server._Handler, 'timeout', 0.05)
    served = PageServer('127.0.0.1', 0, 'page', POLICY, answer)
    try:
        with socket.create_connection(('127.0.0.1', served.port), patience(5.0)) as silent:
            assert silent.recv(100) == b''
    finally:
        served.close()
