"""The gallery: every figure with its caption, its tables and its origin; and the points of figures without a table."""

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection

from millprint.config.errors import ConfigError
from millprint.figures.style import DRAWN_COLUMNS, both_of, save
from millprint.report.gallery import first_sentence, render_caption
from millprint.run.files import read_table
from millprint.run.outputs import captioned

CONFIG = {"name": "made", "results": "results"}


def test_a_figure_has_the_tables_of_its_own_contact_set_and_no_other():
    found = captioned("fingerprint/figures/master_curves_steel.svg")
    assert found.words == {"contact": "steel"}
    assert "fingerprint/means_steel.tsv" in found.data and "fingerprint/descriptors.tsv" in found.data
    # The pattern of a single figure comes before that of many.
    assert captioned("convergence/timestep.svg").data == ("convergence/timestep.tsv",)
    assert captioned("mills/wear.svg").data == ("mills/wear.tsv",)
    with pytest.raises(ConfigError, match=r"^doe/new.svg: no record of this figure"):
        captioned("doe/new.svg")


def test_a_caption_knows_the_configuration_and_the_words_of_its_path():
    text = 'Curves of *{{ snakemake.config["name"] }}* in ``{{ snakemake.wildcards.contact }}.tsv`` & more. The rest.'
    caption = render_caption(text, CONFIG, {"contact": "steel"})
    assert "<em>made</em>" in caption and "steel.tsv" in caption and "&amp; more" in caption
    assert first_sentence(caption) == "Curves of made in steel.tsv & more."


def test_a_caption_reads_no_files_and_brings_no_markup_of_its_own():
    caption = render_caption(".. include:: /etc/passwd\n\n.. raw:: html\n\n   <script>x</script>\n\nText.", CONFIG, {})
    assert "root:" not in caption and "<script" not in caption and "Text." in caption


def test_only_the_ending_of_a_figure_is_taken_from_a_name():
    for name in ("warm_1.5h", "warm_1.5h.png", "warm_1.5h.svg"):
        assert both_of(name) == ("warm_1.5h.svg", "warm_1.5h.png")


def test_the_points_of_lines_marks_outlines_maps_and_images_are_tabulated(tmp_path):
    figure, (left, right) = plt.subplots(1, 2)
    left.plot([0, 1, 2], [5, 6, 7], label="line")
    left.axhline(3)
    left.scatter([1, 2], [3, 4], c=[0.5, 0.7], label="marks")
    left.add_collection(LineCollection([[(0, 0), (1, 1)], [(2, 2), (3, 3)]]))
    discs = EllipseCollection([1], [1], [0], offsets=[(8, 9)], offset_transform=left.transData, array=np.array([4.0]))
    left.add_collection(discs)
    image = right.imshow([[1.0, 2.0], [3.0, 4.0]], origin="lower", extent=(0, 2, 10, 12))
    figure.colorbar(image, ax=right)
    # Of no artist of the figure.
    figure.colorbar(ScalarMappable(), ax=left)
    mesh = right.pcolormesh([0, 1, 2], [0, 1], [[7.0, 8.0]])
    assert mesh.get_array().size == 2
    save(figure, tmp_path / "a.svg", tmp_path / "a.png", tsv=tmp_path / "a.tsv")
    table = read_table(tmp_path / "a.tsv", text=["kind"])
    assert list(table) == DRAWN_COLUMNS and set(table["panel"]) == {1, 2}

    def points(kind: str) -> list[tuple[float, ...]]:
        return [tuple(row) for row in table.loc[table["kind"] == kind, ["x", "y", "value"]].fillna(-1).to_numpy()]

    assert points("Line2D") == [(0, 5, -1), (1, 6, -1), (2, 7, -1)]
    assert points("PathCollection") == [(1, 3, 0.5), (2, 4, 0.7)]
    assert points("LineCollection") == [(0, 0, -1), (1, 1, -1), (2, 2, -1), (3, 3, -1)]
    assert points("EllipseCollection") == [(8, 9, 4)]
    assert points("AxesImage") == [(0.5, 10.5, 1), (1.5, 10.5, 2), (0.5, 11.5, 3), (1.5, 11.5, 4)]
    assert points("QuadMesh") == [(0.5, 0.5, 7), (1.5, 0.5, 8)]
    assert set(table.loc[table["kind"] == "Line2D", "label"]) == {"line"}
