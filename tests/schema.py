"""The JSON schema that `qrm schema` writes accepts every scene, and rejects keys that the reader does not know.

usage: python3 tests/schema.py path/to/qrm
"""

import json
import pathlib
import subprocess
import sys
import tomllib

import jsonschema

top = pathlib.Path(__file__).resolve().parent.parent
schema = json.loads(subprocess.run([sys.argv[1], "schema"], check=True, capture_output=True, text=True).stdout)
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)


def is_valid(path):
    return validator.is_valid(tomllib.loads(path.read_text()))


folders = ["scenes", "examples", "tests/linkage", "tests/extremes", "tests/singular", "crates/cli/src/commands/new"]
scenes = [path for folder in folders for path in sorted((top / folder).rglob("*.toml"))]
scenes = [path for path in scenes if "run" in tomllib.loads(path.read_text())]
for path in scenes:
    errors = list(validator.iter_errors(tomllib.loads(path.read_text())))
    assert not errors, f"{path}: {errors[0].json_path}: {errors[0].message}"
assert len(scenes) > 60, len(scenes)

# Reports of unknown keys and of values of a wrong type; warnings and other errors are beyond a schema.
unknown = accepted = 0
for report in sorted((top / "crates/scene/tests/errors").glob("*.txt")):
    text = report.read_text()
    path = report.with_suffix(".toml")
    try:
        is_accepted = is_valid(path)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError):
        continue
    if text.startswith("error: unknown key"):
        # Some keys belong to other kinds of entries of the section.
        is_elsewhere = f'"{text.split("`")[1]}": {{' in json.dumps(schema)
        unknown += not is_accepted
        assert is_elsewhere or not is_accepted, f"{path} has an unknown key"
    accepted += text.startswith("warning") and is_accepted
    assert is_accepted or not text.startswith("warning"), f"{path} can be read"
assert unknown >= 10 and accepted >= 5, (unknown, accepted)
print(f"{len(scenes)} scenes accepted, {unknown} unknown keys rejected")
