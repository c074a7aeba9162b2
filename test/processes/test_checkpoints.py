"""Checkpoints of processes that are killed, whenever that may be."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

KILLS = 200
# Children write numbered contents, and tell when each is there. Each is killed a seeded number of
# writes later, after a wait that is counted in turns of a loop: no time decides what must hold.
KILLING = """
import json, os, random, signal, sys
from pathlib import Path
from obs_ros.interface.checkpoint_file import decode, encode, read, write

path, kills, chance = Path(sys.argv[1]), int(sys.argv[2]), random.Random(7)
number, parts, told = 0, 0, []
for _ in range(kills):
    heard, spoken = os.pipe()
    child = os.fork()
    if child == 0:
        while True:
            number += 1
            size = 1 + number * 7919 % 50_000
            write(path, encode({'number': number, 'values': [number] * size}))
            os.write(spoken, b'.')
    os.close(spoken)
    for _ in range(chance.randrange(3)):
        os.read(heard, 1)
    for _ in range(chance.randrange(200_000)):
        pass
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(heard)
    parts += path.with_name('tank.part').exists()
    if path.exists():
        content = decode(read(path))
        number = content['number']
        told.append([number, len(content['values']), set(content['values']) == {number}])
print(json.dumps({'parts': parts, 'told': told, 'left': sorted(os.listdir(path.parent))}))
"""


def test_whenever_a_process_is_killed_its_file_loads(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, '-c', KILLING, str(tmp_path / 'tank'), str(KILLS)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    numbers = [number for number, _, _ in found['told']]
    assert len(numbers) > KILLS // 2 and numbers == sorted(numbers) and numbers[-1] > KILLS // 4
    assert all(whole and size == 1 + n * 7919 % 50_000 for n, size, whole in found['told'])
    assert found['parts'] > 0  # some were killed in the middle of a write
    assert set(found['left']) <= {'tank', 'tank.part'}
