"""The pages, one a file."""

from page.server import Site


def pages(site: Site) -> None:
    """Register every page."""
    from page.views import bench, recording

    bench.register(site)
    recording.register(site)
