"""Remote vision: a web page with the images of a team's cameras, their vision operations, and the camera heads.

`acromovi remote-vision ROBOT` serves it. The page reads the streams of cameras and vision agents, and moves a head
through its agent, with a lease. It needs the extra `console`.
"""
