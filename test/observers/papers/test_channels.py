"""Tests of obs_ros.observers.papers.channels."""

from obs_ros.observers.papers.channels import each, products


def test_each_channel_gets_its_own_entries_and_all_get_the_settings() -> None:
    def first(*entries: float) -> tuple[float, ...]:
        return entries

    def second(a: float, b: float, c: float, d: float, e: float, f: float, s: float) -> float:
        return a + b + c + d + e + f + s

    tuples = [(float(k), 10.0 * k) for k in range(1, 7)]
    found = each([first, second])(*tuples, 0.5)
    assert found == ((1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.5), 210.5)
    assert each([second])(*tuples, 0.0) == (21.0,)


def test_products_take_the_second_factor_by_its_index() -> None:
    assert products([2, 0])((3.0, 5.0), (7.0, 11.0, 13.0)) == (39.0, 35.0)
