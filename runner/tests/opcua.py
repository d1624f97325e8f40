"""Reads a monitor with the client of asyncua: prints what it sees, one JSON object."""

import asyncio
import json
import sys

from asyncua import Client
from asyncua.ua.uaerrors import UaError


class Seconds:
    """Values of a subscription."""

    def __init__(self) -> None:
        self.seen: list[float] = []

    def datachange_notification(self, _node: object, value: float, _data: object) -> None:
        self.seen.append(value)


async def main(port: str) -> None:
    async with Client(f"opc.tcp://127.0.0.1:{port}/") as client:
        namespace = await client.get_namespace_index("urn:ballrace:monitor")
        folder = await client.nodes.objects.get_child(f"{namespace}:machine")

        async def node(name: str):
            return await folder.get_child(f"{namespace}:{name}")

        async def names() -> set[str]:
            return {(await child.read_browse_name()).Name for child in await folder.get_children()}

        while "time_s" not in await names():
            await asyncio.sleep(0.05)
        time, seconds = await node("time_s"), Seconds()
        subscription = await client.create_subscription(100, seconds)
        await subscription.subscribe_data_change(time)
        print("subscribed", flush=True)
        while len(seconds.seen) < 3:
            await asyncio.sleep(0.05)
        rms = await (await node("DE_X_um_rms_um")).read_data_value()
        try:
            await time.write_value(5.0)
            written = "written"
        except UaError as error:
            written = type(error).__name__
        print(
            json.dumps(
                {
                    "names": sorted(await names()),
                    "seconds": seconds.seen,
                    "rms": rms.Value.Value,
                    "at": rms.SourceTimestamp.isoformat(),
                    "event": await (await node("event")).read_value(),
                    "written": written,
                }
            )
        )


asyncio.run(asyncio.wait_for(main(sys.argv[1]), 60))
