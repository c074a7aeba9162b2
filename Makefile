# A sourced ROS must not mix with the wheels in .venv, and everything stays on this machine.
ifneq ($(AMENT_PREFIX_PATH)$(_ROS_WHEELS_BOOTSTRAP_COMPLETE),)
unexport LD_LIBRARY_PATH
endif
unexport PYTHONPATH PYTHONHOME RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE
export AMENT_PREFIX_PATH := $(CURDIR)/.venv
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST

bin := .venv/bin

.PHONY: help setup peers design demo test clean

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/make \1\t\2/p' Makefile
	@echo 'PYTHON=/path/to/python chooses the Python (3.11, 3.12 or 3.13) that .venv is made with.'

setup:  ## build .venv with all that demo and test need
	@tools/setup.sh test

peers:  ## what benchmarks.peers compares with, into .venv
	@tools/setup.sh peers

design:  ## what obs_ros.design solves matrix inequalities with, into .venv
	@tools/setup.sh design

demo:  ## simulator and estimator on the three-tank plant: estimates beside the truth, demo.png
	@tools/setup.sh runtime
	@$(bin)/python -m demo.three_tank

test: setup  ## lint, format, types, tests
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/mypy
	$(bin)/python -m pytest

clean:  ## remove .venv and everything else that was built
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis demo.png
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
