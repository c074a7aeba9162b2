"""Fast DDS with as little memory for a topic as it needs, for processes with very many of them.

Its readers and writers hold room for a hundred messages from the start, 45 to 60 KB each, and a
plant has some thirty. Here that room grows with what waits in it.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

# What rmw_fastrtps sets itself has to stand here too: with this it leaves everything to the file.
_TAKEN_FROM_FILE = 'RMW_FASTRTPS_USE_QOS_FROM_XML'
_FILE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
_ENDPOINT = """
    <{kind} profile_name="lean_{kind}" is_default_profile="true">
      <topic>
        <resourceLimitsQos><allocated_samples>1</allocated_samples></resourceLimitsQos>
      </topic>
      <qos><data_sharing><kind>OFF</kind></data_sharing></qos>
      <historyMemoryPolicy>PREALLOCATED_WITH_REALLOC</historyMemoryPolicy>
    </{kind}>"""
_PROFILES = f"""<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>{
    ''.join(_ENDPOINT.format(kind=kind) for kind in ('data_writer', 'data_reader'))
}
</profiles></dds>
"""


@contextmanager
def lean_middleware() -> Iterator[None]:
    """Let the middleware take little memory, if the first node of the process is made here.

    Whoever has settings of Fast DDS keeps them, and other middlewares do not read these.
    """
    if {_TAKEN_FROM_FILE, _FILE, 'FASTDDS_DEFAULT_PROFILES_FILE'} & set(os.environ):
        yield
        return
    with tempfile.NamedTemporaryFile('w', prefix='obs_ros_', suffix='.xml') as file:
        file.write(_PROFILES)
        file.flush()
        os.environ |= {_TAKEN_FROM_FILE: '1', _FILE: file.name}
        try:
            yield
        finally:
            for name in (_TAKEN_FROM_FILE, _FILE):
                os.environ.pop(name)
