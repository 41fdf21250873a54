//! A scene in a browser, which follows the scene's file.

mod feed;
mod form;
mod server;
mod session;
mod values;
mod watch;

pub(crate) use feed::Feed;
pub(crate) use server::Server;
pub(crate) use session::Session;
