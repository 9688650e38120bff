"""The web console: a team on one page in a browser.

Everything comes from the bus; the console knows nothing of the wire. `pages.py` lists the pages, `robot_page.py` the
panels of a robot. It needs the extra `console`.
"""
