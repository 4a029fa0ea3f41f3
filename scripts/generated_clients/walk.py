"""Matches an example creature with a generated client, in the directory that holds it: walk.py SERVER"""

import io
import json
import struct
import sys
from pathlib import Path

sys.path.insert(0, ".")
from sketchmatch_client import Client
from sketchmatch_client.api.matches import create_match, draw_match, follow_match, read_match, read_result
from sketchmatch_client.api.meshes import upload_mesh
from sketchmatch_client.api.sketches import upload_sketch
from sketchmatch_client.models import (
    MatchDocument,
    MatchRequest,
    OutlineRequest,
    Problem,
    UploadMeshFilesBody,
    UploadMeshFormat,
)
from sketchmatch_client.types import File

client = Client(base_url=sys.argv[1], timeout=60)

form = UploadMeshFilesBody(file=File(io.BytesIO(Path("mesh.obj").read_bytes()), "mesh.obj", "model/obj"))
mesh = upload_mesh.sync(client=client, body=form, name="a cat")
assert mesh.closed and mesh.components == 1 and mesh.vertices > 4000, mesh
raw = upload_mesh.sync(client=client, body=File(io.BytesIO(Path("mesh.obj").read_bytes())), format_=UploadMeshFormat.OBJ)
assert raw.id == mesh.id, (raw, mesh)

sketch = upload_sketch.sync(client=client, body=OutlineRequest.from_dict(json.loads(Path("sketch.json").read_text())))
assert sketch.vertices > 700 and sketch.warnings == [], sketch

asked = create_match.sync(client=client, body=MatchRequest(mesh=mesh.id, sketch=sketch.id))
assert isinstance(asked, MatchDocument), asked

# The generated call reads a whole answer as one document; the stream of events is read line by line.
with client.get_httpx_client().stream(**follow_match._get_kwargs(asked.id)) as events:
    told = [line.removeprefix("data:") for line in events.iter_lines() if line.startswith("data:")]
last = MatchDocument.from_dict(json.loads(told[-1]))
assert (last.status, last.progress.fraction) == ("succeeded", 1.0), last

answer = read_result.sync(asked.id, client=client)
assert len(answer.correspondences) == sketch.vertices
assert (answer.c.rows, answer.c.columns, answer.rating) == (20, 20, "high"), answer.rating
assert (answer.mesh, answer.sketch, answer.match) == (mesh.id, sketch.id, asked.id)

picture = draw_match.sync(asked.id, client=client, width=400).payload.read()
assert picture[1:4] == b"PNG" and struct.unpack(">I", picture[16:20]) == (400,)

missing = read_match.sync("none", client=client)
assert isinstance(missing, Problem) and missing.status == 404, missing
print(f"matched {len(answer.correspondences)} points, {answer.rating}")
