"""Nodes that are altered when they have been built."""

from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer


class AlteredNode(Node):
    """Has at most ``most_further`` channels beside the default one; None leaves it all of them."""

    most_further: int | None = None

    def __init__(
        self,
        node_id: int,
        server: SegmentedServer,
        *further: SegmentedServer,
        server_timeout: float | None = None,
    ) -> None:
        """Build the node, then alter it."""
        super().__init__(
            node_id, server, *further[: self.most_further], server_timeout=server_timeout
        )
        self.alter()

    def alter(self) -> None:
        """Leave the node as it is."""
