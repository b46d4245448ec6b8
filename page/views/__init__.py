"""The pages, one a file."""

from benchtwin.page.site import Site


def pages(site: Site) -> None:
    """Register every page."""
    from benchtwin.page.views import bench, recording

    bench.register(site)
    recording.register(site)
