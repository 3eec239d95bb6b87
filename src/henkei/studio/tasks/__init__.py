"""Long work of the studio, done in worker processes: a function ``run`` in each module.

    def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]

The request and what is returned are data that JSON can hold; surfaces and results are blobs.
"""
