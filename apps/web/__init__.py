"""What the pages of applications share: serving them to this computer, and images that the browser requests.

They need the extra `console`.
"""
