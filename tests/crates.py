"""Holds a crate against its profile with roc-validator, without a network.

The validator reads the terms of RO-Crate 1.1 from the web. Here they come from its HTTP cache, which is filled with
those that ro-crate-py ships: they are of version 1.3, so what it has in another form or added since is put right.
"""

import json
from importlib.resources import files
from io import BytesIO
from pathlib import Path

import requests
from requests_cache import CachedSession
from rocrate_validator import services
from urllib3 import HTTPResponse

CONTEXT = "https://w3id.org/ro/crate/1.1/context"
PROFILE = "workflow-run-crate"
WORKFLOW = "https://bioschemas.org/ComputationalWorkflow"
TERMS_OF_1_1 = {
    "ComputationalWorkflow": WORKFLOW,
    "FormalParameter": "https://bioschemas.org/FormalParameter",
    "input": f"{WORKFLOW}#input",
    "output": f"{WORKFLOW}#output",
}
NOT_IN_1_1 = ("sha256",)


def _fill_cache(path: Path) -> None:
    """Store the terms as the answer to a request for them."""
    shipped = json.loads((files("rocrate") / "data/ro-crate.jsonld").read_text())["@context"]
    terms = {key: value for key, value in shipped.items() if key not in NOT_IN_1_1} | TERMS_OF_1_1
    body = json.dumps({"@context": terms}).encode()
    headers = {"Content-Type": "application/ld+json"}
    answer = requests.Response()
    answer.status_code, answer.url = 200, CONTEXT
    answer.headers.update(headers)
    answer.request = requests.Request("GET", CONTEXT).prepare()
    answer.raw = HTTPResponse(
        body=BytesIO(body), headers=headers, status=200, preload_content=False, request_url=CONTEXT
    )
    with CachedSession(cache_name=str(path), expire_after=-1) as session:
        session.cache.save_response(answer)


def faults_of(crate: Path, folder: Path, severity: str = "REQUIRED") -> list[str]:
    """What the validator finds wrong with the crate in a folder, at a severity and above; `folder` takes its cache."""
    cache = folder / "terms"
    _fill_cache(cache)
    settings = services.ValidationSettings(
        rocrate_uri=str(crate),
        profile_identifier=PROFILE,
        requirement_severity=severity,
        offline=True,
        cache_path=cache,
    )
    result = services.validate(settings)
    return sorted({f"{issue.check.identifier}: {issue.message}" for issue in result.get_issues()})
