// Starts `qrm lsp` for TOML files that are scenes.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

// A scene begins with its name.
const isScene = (document) => /^(\s*#.*\n|\s)*name\s*=\s*["']/.test(document.getText());

let client;

exports.activate = () => {
    const program = workspace.getConfiguration("qrm").get("program");
    const only = (document, next) => (isScene(document) ? next(document) : undefined);
    client = new LanguageClient(
        "qrm",
        { command: program, args: ["lsp"] },
        {
            documentSelector: [{ language: "toml" }, { language: "qrm" }],
            middleware: {
                didOpen: only,
                didSave: only,
                didClose: only,
                didChange: (event, next) => (isScene(event.document) ? next(event) : undefined),
            },
        },
    );
    return client.start();
};

exports.deactivate = () => client?.stop();
