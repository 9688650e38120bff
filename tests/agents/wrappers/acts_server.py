"""A server of the colour protocol of ACTS, written from its description alone: `python acts_server.py PORT`.

It sees two red things and a blue one, which moves a pixel to the right with each picture. It ends when it is told to.
"""

import socket
import sys


def six_bits(number: int, width: int) -> bytes:
    """A number as ACTS says it: the highest six bits first, each byte one more than it means."""
    digits = []
    for _ in range(width):
        number, digit = divmod(number, 64)
        digits.append(digit + 1)
    return bytes(reversed(digits))


def blob(area: int, x: int, y: int, left: int, right: int, top: int, bottom: int) -> bytes:
    """One blob of version 2.0."""
    return six_bits(area, 4) + b"".join(six_bits(each, 2) for each in (x, y, left, right, top, bottom))


def packet(channels: dict[int, list[bytes]]) -> bytes:
    """A header for 32 channels, and the blobs."""
    header, first = b"", 0
    for channel in range(1, 33):
        blobs = channels.get(channel, [])
        header += six_bits(first, 2) + six_bits(len(blobs), 2)
        first += len(blobs)
    return header + b"".join(one for channel in sorted(channels) for one in channels[channel])


def serve(port: int) -> None:
    """Serve one client after the other."""
    pictures = 0
    with socket.create_server(("127.0.0.1", port)) as server:
        while True:
            client, _ = server.accept()
            with client:
                while asked := client.recv(1):
                    if asked == b"1":
                        return
                    red = [blob(5000, 80, 60, 40, 120, 30, 90), blob(12, 5, 6, 4, 6, 5, 7)]
                    blue = [blob(70, 20 + pictures, 10, 15, 25, 5, 15)]
                    pictures += 1
                    client.sendall(packet({1: red, 7: blue}))


if __name__ == "__main__":
    serve(int(sys.argv[1]))
