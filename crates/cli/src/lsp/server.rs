//! The messages of the protocol.

use std::collections::HashMap;

use lsp_server::{Connection, Message, Notification, ProtocolError, Response};
use qrm_core::Model;
use qrm_scene::diagnostic::{Diagnostic, Severity};
use qrm_scene::resolve;
use serde_json::{Value, json};

use super::completion::completion;
use super::edit::{definitions, references, rename};
use super::hover::hover;
use super::text::Text;
use super::values::Values;

/// The error code of requests that cannot be done.
const REQUEST_FAILED: i32 = -32803;
/// The error code of unknown methods.
const METHOD_NOT_FOUND: i32 = -32601;

/// The capabilities of the server.
pub(crate) fn capabilities() -> Value {
    json!({
        "positionEncoding": "utf-16",
        "textDocumentSync": { "openClose": true, "change": 1, "save": true },
        "completionProvider": { "triggerCharacters": ["\"", "'", "{", "[", " ", "."] },
        "hoverProvider": true,
        "definitionProvider": true,
        "referencesProvider": true,
        "renameProvider": true,
    })
}

/// An open file.
struct Open {
    text: Text,
    /// Numbers at the start, of the text as it was opened or saved.
    values: Values,
}

struct Server<'c> {
    models: &'static [Model],
    connection: &'c Connection,
    open: HashMap<String, Open>,
}

/// Answers the messages of an editor until it ends the connection.
///
/// # Errors
/// The protocol is violated.
pub(crate) fn serve(models: &'static [Model], connection: &Connection) -> Result<(), ProtocolError> {
    let mut server = Server { models, connection, open: HashMap::new() };
    for message in &connection.receiver {
        match message {
            Message::Request(request) => {
                if connection.handle_shutdown(&request)? {
                    break;
                }
                let answer = match server.answer(&request.method, &request.params) {
                    Ok(result) => Response::new_ok(request.id, result),
                    Err((code, reason)) => Response::new_err(request.id, code, reason),
                };
                server.send(answer.into());
            }
            Message::Notification(notification) => server.take(&notification),
            Message::Response(_) => {}
        }
    }
    Ok(())
}

impl Server<'_> {
    fn send(&self, message: Message) {
        // A closed connection ends the loop that reads it.
        let _ = self.connection.sender.send(message);
    }

    fn take(&mut self, notification: &Notification) {
        let Notification { method, params } = notification;
        let uri = params["textDocument"]["uri"].as_str().unwrap_or_default().to_owned();
        match method.as_str() {
            "textDocument/didOpen" => {
                let source = params["textDocument"]["text"].as_str().unwrap_or_default();
                let values = Values::default();
                self.open.insert(uri.clone(), Open { text: Text::new(source.to_owned()), values });
                self.publish(&uri);
                self.evaluate(&uri);
            }
            "textDocument/didChange" => {
                let last = params["contentChanges"].as_array().and_then(|changes| changes.last());
                let source = last.and_then(|change| change["text"].as_str());
                if let (Some(open), Some(source)) = (self.open.get_mut(&uri), source) {
                    open.text = Text::new(source.to_owned());
                    self.publish(&uri);
                }
            }
            "textDocument/didSave" => self.evaluate(&uri),
            "textDocument/didClose" => {
                self.open.remove(&uri);
            }
            _ => {}
        }
    }

    /// Computes the numbers at the start.
    fn evaluate(&mut self, uri: &str) {
        if let Some(open) = self.open.get_mut(uri) {
            open.values = Values::at_start(self.models, &path(uri), &open.text.source);
        }
    }

    /// Sends the mistakes of a file.
    fn publish(&self, uri: &str) {
        let Some(Open { text, .. }) = self.open.get(uri) else { return };
        let (Ok((_, report)) | Err(report)) = resolve::read(&path(uri), &text.source);
        let found: Vec<Value> = report.diagnostics.iter().map(|found| diagnostic(text, found)).collect();
        let params = json!({ "uri": uri, "diagnostics": found });
        self.send(Notification::new("textDocument/publishDiagnostics".to_owned(), params).into());
    }

    fn answer(&self, method: &str, params: &Value) -> Result<Value, (i32, String)> {
        let uri = params["textDocument"]["uri"].as_str().unwrap_or_default();
        let found = self.open.get(uri);
        let place = found.and_then(|open| Some((open, open.text.byte(&params["position"])?)));
        let Some((Open { text, values }, byte)) = place else { return Ok(Value::Null) };
        let locations = |spans: Vec<std::ops::Range<usize>>| {
            spans.iter().map(|span| json!({ "uri": uri, "range": text.range(span) })).collect::<Vec<_>>()
        };
        Ok(match method {
            "textDocument/completion" => json!(completion(text, byte)),
            "textDocument/hover" => hover(text, values, byte).unwrap_or_default(),
            "textDocument/definition" => json!(locations(definitions(text, byte))),
            "textDocument/references" => json!(locations(references(text, byte))),
            "textDocument/rename" => {
                let new = params["newName"].as_str().unwrap_or_default();
                let edits = rename(text, &path(uri), byte, new).map_err(|reason| (REQUEST_FAILED, reason))?;
                json!({ "changes": { uri: edits } })
            }
            _ => return Err((METHOD_NOT_FOUND, format!("`{method}` is not offered"))),
        })
    }
}

/// A diagnostic of the protocol.
fn diagnostic(text: &Text, found: &Diagnostic) -> Value {
    let span = found.span.clone().unwrap_or(0..0);
    let help = found.help.as_ref().map_or(String::new(), |help| format!("\nhelp: {help}"));
    let severity = if found.severity == Severity::Error { 1 } else { 2 };
    json!({
        "range": text.range(&span),
        "severity": severity,
        "source": "qrm",
        "message": format!("{}{help}", found.title),
    })
}

/// The path of a URI, as messages show it.
fn path(uri: &str) -> String {
    let path = uri.strip_prefix("file://").unwrap_or(uri);
    let mut bytes = Vec::new();
    let mut rest = path.bytes();
    while let Some(byte) = rest.next() {
        let code = (byte == b'%').then(|| {
            let digits: Vec<u8> = rest.clone().take(2).collect();
            u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()
        });
        match code.flatten() {
            Some(code) => {
                bytes.push(code);
                rest.nth(1);
            }
            None => bytes.push(byte),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
