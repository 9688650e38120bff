"""The panels of the page Robot, one module each; `apps/console/robot_page.py` has the table of them."""
