"""The recorder of the demo holds the plant for the estimator, and never for ever."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_srvs.srv import SetBool

from demo.recorder import Recorder

WINDOW, PERIOD = 300.0, 50.0  # s


class Plant:
    """What the recorder hears and asks, in place of simulator and estimator."""

    def __init__(self, ros):
        self.asked = []
        ros.node.create_service(SetBool, 'simulator/enable', self._answer)
        self._ros = ros
        self.recorder = ros.start(Recorder)
        self._diagnostics = ros.node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._state = ros.speak('plant/state')
        ros.spin_until(self._diagnostics.get_subscription_count)
        ros.spin_until(lambda: ros.node.count_clients('simulator/enable'))
        self.recorder.start_plant()
        ros.spin_until(lambda: self.asked == [True])

    def _answer(self, request, response):
        self.asked.append(request.data)
        response.success = True
        return response

    def goes(self, time):
        """Let the plant come to a time in s."""
        self._state(time, ['h1'], [1.0])
        self.until(lambda: self.recorder.plant_time == time)

    def estimator_says(self, outcome, solving):
        words = {'ready': 'true', 'outcome': outcome, 'solving': solving}
        values = [KeyValue(key=key, value=value) for key, value in words.items()]
        self._diagnostics.publish(DiagnosticArray(status=[DiagnosticStatus(values=values)]))

    def until(self, predicate):
        def happened():
            self.recorder.pace(WINDOW, PERIOD)
            return predicate()

        self._ros.spin_until(happened)


@pytest.mark.parametrize('outcome', ['stale_output', 'stale_input', 'waiting'])
def test_an_estimator_that_missed_samples_gets_later_ones(ros, outcome):
    plant = Plant(ros)
    plant.goes(WINDOW + 2.1 * PERIOD)
    plant.until(lambda: plant.asked == [True, False])
    plant.estimator_says(outcome, 'false')
    plant.until(lambda: plant.asked == [True, False, True])
    plant.estimator_says('collecting', 'false')
    plant.until(lambda: plant.asked == [True, False, True, False])


def test_an_estimator_that_solves_is_waited_for(ros):
    plant = Plant(ros)
    plant.goes(WINDOW + 2.1 * PERIOD)
    plant.until(lambda: plant.asked == [True, False])
    plant.estimator_says('stale_output', 'true')
    plant.until(lambda: plant.recorder.estimator_ready)
    plant.goes(WINDOW + 2.2 * PERIOD)
    assert plant.asked == [True, False]
