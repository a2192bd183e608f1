# SPDX-License-Identifier: LGPL-3.0-or-later
"""A report in a headless Chromium: drawn without a fault, and it does what its controls say."""

import re

import pytest

from tests.report.browser import Browser, chromium

pytestmark = [
    pytest.mark.serial,
    pytest.mark.skipif(chromium() is None, reason="no chromium here: apt-get install chromium"),
]
SAYS = "document.getElementById('{name}').dispatchEvent(new Event('{event}', {{bubbles: true}}))"
WALK = "document.getElementById('walk_view')"
TIME = "document.getElementById('over_time')"


@pytest.fixture(scope="module")
def browser(written):
    with Browser(written, 1280) as opened:
        yield opened


def choose(browser, name, value, event="change"):
    """Give a control a value as a person does."""
    browser.run(f"document.getElementById('{name}').value = '{value}'")
    browser.run(SAYS.format(name=name, event=event))


def cloth(browser):
    """Heights of the first run's cloth, rounded, as drawn."""
    return browser.run(f"Array.from({WALK}.data[0].z, (v) => Math.round(1e4 * v))")


def curve(browser):
    """Torque of the last curve over time."""
    return browser.run(f"{TIME}.data[{TIME}.data.length - 1].y")


def settled(browser):
    """Wait for what is being drawn."""
    browser.run("new Promise((done) => setTimeout(done, 700))")


def test_all_is_drawn_without_a_fault(browser):
    """Console, exceptions, requests; curves and surfaces are there, with their canvases."""
    drawn = "Array.from(document.querySelectorAll('.js-plotly-plot'), (plot) => plot.id)"
    assert browser.run(drawn) == ["over_time", "over_phase", "walk_view", "skin_view"]
    assert browser.run("document.querySelectorAll('#walk_view canvas').length") >= 1
    assert browser.run("document.querySelectorAll('#over_time .scatterlayer .trace').length") > 1
    assert browser.run("document.querySelectorAll('section h2').length") == 7
    assert browser.faults == []


def test_no_button_sends_the_figure_away(browser):
    titles = "Array.from(document.querySelectorAll('.modebar-btn'), (b) => b.dataset.title)"
    found = browser.run(titles)
    assert found and not [title for title in found if re.search("cloud|share|edit", title, re.I)]


def test_scrubbing_moves_the_walk(browser):
    last = int(browser.run("document.getElementById('frame').max"))
    choose(browser, "frame", 0, "input")
    settled(browser)
    first, clock = cloth(browser), browser.run("document.getElementById('clock').textContent")
    choose(browser, "frame", last, "input")
    settled(browser)
    assert cloth(browser) != first
    assert browser.run("document.getElementById('clock').textContent") != clock
    mark = browser.run(f"{TIME}.layout.shapes[0].x0")
    times = "JSON.parse(document.getElementById('data').textContent).runs[0].walk.times"
    assert mark == browser.run(times)[last]
    assert browser.faults == []


def test_keys_step_and_play(browser):
    choose(browser, "frame", 0, "input")
    press = f"{WALK}.dispatchEvent(new KeyboardEvent('keydown', {{key: '%s', cancelable: true}}))"
    browser.run(press % "ArrowRight")
    settled(browser)
    assert browser.run("document.getElementById('frame').value") == "1"
    browser.run(press % " ")
    assert browser.run("document.getElementById('play').textContent") == "Pause"
    browser.wait("document.getElementById('frame').value !== '1'")
    browser.run(press % " ")
    assert browser.run("document.getElementById('play').textContent") == "Play"
    order = "Array.from(document.querySelectorAll('button, select, input'), (e) => e.tabIndex)"
    assert set(browser.run(order)) == {0}


def test_switching_joints_changes_the_curve(browser):
    options = "Array.from(document.getElementById('joint').options, (o) => o.value)"
    data = "JSON.parse(document.getElementById('data').textContent).runs[1].joints"
    for joint in browser.run(options)[:2]:
        choose(browser, "joint", joint)
        settled(browser)
        assert curve(browser) == browser.run(f"{data}.{joint}.torque")


def test_runs_can_be_left_out(browser):
    count = browser.run(f"{TIME}.data.length")
    browser.run("document.getElementById('run_0').click()")
    settled(browser)
    assert browser.run(f"{TIME}.data.length") == count // 2
    assert browser.run(f"{WALK}.data.some((trace) => trace.scene === 'scene2')") is False
    browser.run("document.getElementById('run_0').click()")
    settled(browser)
    assert browser.run(f"{TIME}.data.length") == count
    assert browser.faults == []


def test_cloth_is_coloured_by_what_is_chosen(browser):
    kinds = browser.run("Array.from(document.getElementById('colour').options, (o) => o.value)")
    assert kinds[:2] == ["pressure", "stretch"] and kinds[-1] == ""
    choose(browser, "colour", "stretch")
    settled(browser)
    assert browser.run(f"{WALK}.data[0].intensitymode") == "cell"
    triangles = browser.run(f"{WALK}.data[0].i.length")
    assert browser.run(f"{WALK}.data[0].intensity.length") == triangles
    choose(browser, "colour", "")
    settled(browser)
    assert browser.run(f"{WALK}.data[0].intensity === undefined")
    choose(browser, "colour", "pressure")


def test_cameras_are_kept_alike(browser):
    button = "document.querySelector('.views[data-of=walk_view] button')"
    browser.run(f"{button}.click()")
    settled(browser)
    eye = "JSON.stringify({0}.layout.{1}.camera.eye)"
    one, other = (browser.run(eye.format(WALK, name)) for name in ("scene", "scene2"))
    assert one == other is not None
    assert browser.faults == []


def test_on_paper_it_has_six_pages_at_most(browser):
    """Still pictures take the place of what moves."""
    pages = re.findall(rb"/Type\s*/Page\b", browser.printed())
    assert 1 <= len(pages) <= 6


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_window(written, width):
    with Browser(written, width) as opened:
        assert opened.run("document.documentElement.scrollWidth") == width
        wide = "Array.from(document.querySelectorAll('.js-plotly-plot'), (p) => p.clientWidth)"
        assert all(0.8 * width < value <= width for value in opened.run(wide))
        assert opened.faults == []
