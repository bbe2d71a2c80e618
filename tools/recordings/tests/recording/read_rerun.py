"""Reads a recording as Rerun does, and prints what Rerun makes of it as one JSON object."""

import json
import sys

from rerun.chunk import McapReader


def main(path):
    entities, frames, most = {}, set(), {}
    for chunk in McapReader(path).stream().to_chunks():
        if chunk.is_static:
            continue
        batch = chunk.to_record_batch()
        for field, column in zip(batch.schema, batch.columns):
            component = (field.metadata or {}).get(b"rerun:component")
            if component is None:
                continue
            components = entities.setdefault(chunk.entity_path, {})
            name = component.decode()
            components[name] = components.get(name, 0) + len(column.flatten())
            rows = [row for row in column.to_pylist() if row]
            if name == "Transform3D:child_frame":
                frames.update(frame for row in rows for frame in row)
            if name == "Points3D:positions":
                # Chunks come in no order of time, and clouds only grow.
                most[chunk.entity_path] = max([most.get(chunk.entity_path, []), *rows], key=len)
    print(json.dumps({"entities": entities, "frames": sorted(frames), "points": most}))


main(sys.argv[1])
