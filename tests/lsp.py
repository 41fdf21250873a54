"""The language server, by its protocol: diagnostics, completion, hover, definition, references and renaming.

usage: python3 tests/lsp.py path/to/qrm
"""

import json
import pathlib
import statistics
import subprocess
import sys
import time

SCENE = """name = "four-bar"
run = { step = 1e-3, end_time = 1 }
[parameters]
a = { value = 0.1, unit = "m" }
[links]
ground  = { points = { A = [0, 0], D = [0.4, 0] } }
crank   = { bar = ["A", "B"], length = 'a', mass = 1, rate = 10 }
coupler = { bar = ["B", "C"], length = 0.35, mass = 3 }
rocker  = { bar = ["D", "C"], length = 0.25, mass = 2 }
[joints]
A = { revolute = ["crank", "ground"] }
B = { revolute = ["crank", "coupler"], near = [0.07, 0.07] }
C = { revolute = ["coupler", "rocker"], near = [0.35, 0.25] }
D = { revolute = ["rocker", "ground"] }
[outputs]
y = { value = 'C.y + a*0', unit = "m", doc = "a height" }
"""
URI = "file:///tmp/four-bar.toml"


class Editor:
    """An editor that is connected to the server."""

    def __init__(self, program):
        self.server = subprocess.Popen([program, "lsp"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.number = 0
        self.diagnostics = None
        self.ask("initialize", {"capabilities": {}})
        self.tell("initialized", {})

    def send(self, message):
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.server.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.server.stdin.flush()

    def receive(self):
        length = 0
        while (line := self.server.stdout.readline().strip()):
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
        message = json.loads(self.server.stdout.read(length))
        if message.get("method") == "textDocument/publishDiagnostics":
            self.diagnostics = message["params"]["diagnostics"]
        return message

    def tell(self, method, params):
        self.send({"method": method, "params": params})

    def ask(self, method, params):
        self.number += 1
        self.send({"id": self.number, "method": method, "params": params})
        while (message := self.receive()).get("id") != self.number:
            pass
        assert "error" not in message or method == "textDocument/rename", message
        return message.get("result", message.get("error"))

    def change(self, text):
        """Changes the text, and returns the diagnostics and the seconds until they came."""
        begin = time.perf_counter()
        self.diagnostics = None
        self.tell("textDocument/didChange", {"textDocument": {"uri": URI}, "contentChanges": [{"text": text}]})
        while self.diagnostics is None:
            self.receive()
        return self.diagnostics, time.perf_counter() - begin

    def at(self, method, text, part, offset=0, **more):
        """Asks at the begin of a part of the text."""
        place = text.index(part) + offset
        line = text[:place].count("\n")
        character = place - (text.rfind("\n", 0, place) + 1)
        position = {"line": line, "character": character}
        return self.ask(f"textDocument/{method}", {"textDocument": {"uri": URI}, "position": position, **more})


editor = Editor(sys.argv[1])
editor.tell("textDocument/didOpen", {"textDocument": {"uri": URI, "languageId": "toml", "version": 1, "text": SCENE}})
while editor.diagnostics is None:
    editor.receive()
assert editor.diagnostics == [], editor.diagnostics

# Diagnostics have the spans of the reader.
wrong = SCENE.replace("'C.y + a*0'", "'C.y + b*0'")
found, _ = editor.change(wrong)
assert found[0]["severity"] == 1 and "unknown name `b`" in found[0]["message"], found
start = found[0]["range"]["start"]
assert wrong.split("\n")[start["line"]][start["character"] :].startswith("b*0"), found
times = [editor.change(text)[1] for text in [SCENE, wrong] * 25]
assert statistics.median(times) < 0.02, times

# Completion: every key of the schema in its section, names in quotes, formulae and units.
schema = json.loads(subprocess.run([sys.argv[1], "schema"], check=True, capture_output=True, text=True).stdout)


def entry_keys(section):
    value = schema["properties"][section]
    table = value.get("additionalProperties") or value.get("items") or value
    if not isinstance(table, dict):
        table = value
    for choice in table.get("anyOf", [table]):
        if "properties" in choice:
            return set(choice["properties"])
    return set()


keys = 0
for section in ["parameters", "tables", "links", "joints", "bodies", "constraints", "loads", "outputs", "drawing"]:
    text = f"{SCENE}[{section}]\nq = {{ "
    editor.change(text)
    labels = {item["label"] for item in editor.at("completion", text, "q = { ", 6)}
    assert labels == entry_keys(section), (section, labels ^ entry_keys(section))
    keys += len(labels)
    begin = time.perf_counter()
    editor.at("completion", text, "q = { ", 6)
    assert time.perf_counter() - begin < 0.02
assert keys > 80, keys
editor.change(SCENE)
labels = {item["label"] for item in editor.at("completion", SCENE, '"crank", "ground"', 1)}
assert {"crank", "coupler", "rocker", "ground", "A"} <= labels and "a" not in labels, labels
labels = {item["label"] for item in editor.at("completion", SCENE, "'C.y", 1)}
assert {"a", "phi_crank", "phi_crank_dot", "C.x", "sin", "pi"} <= labels, labels
labels = {item["label"] for item in editor.at("completion", SCENE, '"m", doc', 1)}
assert {"m", "N m", "rad/s"} <= labels, labels

# Hover: keys, and names with their values at the start.
assert "a bar from the first point" in editor.at("hover", SCENE, "bar =", 1)["contents"]["value"]
value = editor.at("hover", SCENE, "length = 'a'", 10)["contents"]["value"]
assert "parameter `a`" in value and "a = 0.1" in value, value
value = editor.at("hover", SCENE, "'C.y", 1)["contents"]["value"]
assert "point `C`" in value and "C.x = 0.3" in value and "C.y = 0.2" in value, value
assert "y = 0.2" in editor.at("hover", SCENE, "y = {", 0)["contents"]["value"]

# Definition, references and renaming.
places = editor.at("definition", SCENE, "length = 'a'", 10)
assert [place["range"]["start"]["line"] for place in places] == [3], places
places = editor.at("references", SCENE, "length = 'a'", 10)
assert [place["range"]["start"]["line"] for place in places] == [3, 6, 15], places
edits = editor.at("rename", SCENE, "length = 'a'", 10, newName="radius_of_crank")["changes"][URI]
assert len(edits) == 3, edits
lines = SCENE.split("\n")
for edit in sorted(edits, key=lambda edit: -edit["range"]["start"]["character"]):
    begin, end = edit["range"]["start"], edit["range"]["end"]
    line = lines[begin["line"]]
    lines[begin["line"]] = line[: begin["character"]] + edit["newText"] + line[end["character"] :]
renamed, _ = editor.change("\n".join(lines))
assert renamed == [] and "doc = \"a height\"" in "\n".join(lines), renamed
editor.change(SCENE)
assert "does not fit" in editor.at("rename", SCENE, "length = 'a'", 10, newName="phi_crank")["message"]
edits = editor.at("rename", SCENE, '"crank", "ground"', 1, newName="arm")["changes"][URI]
assert len(edits) == 3, edits

assert editor.ask("shutdown", None) is None
editor.tell("exit", None)
assert editor.server.wait(10) == 0
print(f"{keys} keys completed; diagnostics after {1e3 * statistics.median(times):.1f} ms")
