# A sourced ROS must not mix with the wheels in .venv, and everything stays on this machine.
ifneq ($(AMENT_PREFIX_PATH)$(_ROS_WHEELS_BOOTSTRAP_COMPLETE),)
unexport LD_LIBRARY_PATH
endif
unexport PYTHONPATH PYTHONHOME RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE
# Containers often set it. Every worker and process of the tests would compile all sources again.
unexport PYTHONDONTWRITEBYTECODE
export AMENT_PREFIX_PATH := $(CURDIR)/.venv
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST

bin := .venv/bin

# Files of tests run side by side, one after the other in each worker. One worker more than there
# are processors: tests of nodes mostly wait, for what is said once a second.
jobs := $(shell n=$$(nproc); echo $$((n < 8 ? n + 1 : 8)))
pytest := $(bin)/python -m pytest -n $(jobs) --dist loadfile -rs --durations=10 \
	$(if $(ORDER),-p randomly --randomly-seed=$(ORDER))

.PHONY: help setup fleet peers design docs demo test check test-design test-peers clean

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/make \1\t\2/p' Makefile
	@echo 'ORDER=7 runs tests in a random order, the same for the same number.'
	@echo 'OBS_ROS_TEST_PATIENCE=30 waits 30 times as long as an idle machine needs, in place of 6.'
	@echo 'PYTHON=/path/to/python chooses the Python (3.11, 3.12 or 3.13) that .venv is made with.'

setup:  ## build .venv with all that demo and test need
	@tools/setup.sh test

fleet:  ## what shares studies among processes and machines (Dask), into .venv
	@tools/setup.sh fleet

peers:  ## what benchmarks.peers compares with, into .venv
	@tools/setup.sh peers

design:  ## what obs_ros.observers.papers.design solves matrix inequalities with, into .venv
	@tools/setup.sh design

docs:  ## all pages and the API's as HTML in build/docs; a link that leads nowhere is an error
	@tools/setup.sh docs
	$(bin)/python -m sphinx --fail-on-warning --keep-going -j auto -q -c docs . build/docs
	@echo 'docs: build/docs/docs/index.html'

demo:  ## simulator and estimator on the three-tank plant: estimates beside the truth, demo.png
	@tools/setup.sh runtime
	@$(bin)/python -m demo.three_tank

test: setup  ## lint, format, types, and the tests that take seconds
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/mypy
	$(pytest) -m 'not slow'

check: setup  ## the tests that take longer: processes, documents, benchmarks, the demo
	$(pytest) -m slow

test-design: export OBS_ROS_TEST_EXTRA := test-design
test-design: setup design  ## the tests that need what `make design` installs
	$(pytest) test/observers/papers/design

test-peers: export OBS_ROS_TEST_EXTRA := test-peers
test-peers: setup peers  ## the tests that need what `make peers` installs
	$(pytest) test/benchmarks -k peer

clean:  ## remove .venv and everything else that was built
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis demo.png
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
