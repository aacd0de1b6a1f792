"""Pages that people look at: the report of a bed, and beds side by side.

Data flows one way: spheres and the content of ``report.json`` and ``validation.json`` -> figures, plots and
the view's data -> HTML. Nothing is measured here, so that a page says what ``report.json`` says.
"""

from packgen.page.folder import COMPARISON, compare_folders, picture_folder, report_folder, write_page
from packgen.page.html import comparison_html, report_html
from packgen.page.picture import PICTURES, write_pictures
from packgen.page.spheres import Spheres, read_spheres, spheres_of, view_data

__all__ = [
    "COMPARISON",
    "PICTURES",
    "Spheres",
    "compare_folders",
    "comparison_html",
    "picture_folder",
    "read_spheres",
    "report_folder",
    "report_html",
    "spheres_of",
    "view_data",
    "write_page",
    "write_pictures",
]
