//! `openbench serve`: OSRM's HTTP API.

use std::cell::RefCell;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use openbench_core::with_causes;
use openbench_routing::osrm::{Limits, Service, ServiceMemory};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::args::ServeArgs;
use crate::commands::route::service;
use crate::outcome::{Outcome, tell};

/// Largest number of open connections; more wait.
const CONNECTIONS: usize = 1024;
/// Timeout for the head of a request, and for answers when the server stops.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest life of a connection.
const LONGEST_CONNECTION: Duration = Duration::from_secs(600);
/// Largest head of a request, bytes; hyper limits addresses to 64 KiB anyway.
const LONGEST_HEAD: usize = 128 << 10;

/// Serves until it is stopped.
pub fn run(args: &ServeArgs) -> anyhow::Result<Outcome> {
    let limits = Limits {
        route: args.max_route_places,
        table: args.max_table_places,
        ..Limits::default()
    };
    let service = Arc::new(service(&args.roads, limits)?);
    let mut runtime = tokio::runtime::Builder::new_multi_thread();
    if let Some(threads) = args.threads {
        runtime.worker_threads(threads.into());
    }
    let runtime = runtime
        .enable_all()
        .build()
        .context("cannot start threads")?;
    runtime.block_on(serve(args, service))?;
    Ok(Outcome::Done)
}

async fn serve(args: &ServeArgs, service: Arc<Service>) -> anyhow::Result<()> {
    let listener = TcpListener::bind(args.listen)
        .await
        .with_context(|| format!("cannot listen on {}", args.listen))?;
    // Before the address is printed, since a client may then stop the server at once.
    let mut stop = std::pin::pin!(stopped());
    tell(&format!(
        "{} edges of {} for `{}`; listening on http://{}",
        service.roads.network.edge_count(),
        args.roads.map.display(),
        args.roads.profile,
        listener.local_addr()?
    ));
    let (graceful, room) = (
        GracefulShutdown::new(),
        Arc::new(Semaphore::new(CONNECTIONS)),
    );
    loop {
        let accepted = tokio::select! {
            accepted = accept(&listener, &room) => accepted,
            () = &mut stop => break,
        };
        let (stream, permit) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                // Out of file handles, or a closed connection: others can still be served.
                tracing::warn!("a connection was not accepted: {}", with_causes(&error));
                // A pause, since the same error may return at once: without file handles the loop
                // would spin.
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            }
        };
        // Answers are sent at once, without Nagle's algorithm.
        let _ = stream.set_nodelay(true);
        let service = service.clone();
        let answer = service_fn(move |request| {
            let response = respond(&service, &request);
            async move { Ok::<_, Infallible>(response) }
        });
        let mut builder = hyper::server::conn::http1::Builder::new();
        builder
            // hyper panics at a timeout without a timer.
            .timer(TokioTimer::new())
            .header_read_timeout(PATIENCE)
            .max_buf_size(LONGEST_HEAD);
        let connection = graceful.watch(builder.serve_connection(TokioIo::new(stream), answer));
        tokio::spawn(async move {
            // A client that does not read its answer is not waited for without end.
            match tokio::time::timeout(LONGEST_CONNECTION, connection).await {
                Ok(Err(error)) => {
                    tracing::debug!("a connection ended: {}", with_causes(&error))
                }
                Ok(Ok(())) => {}
                Err(_) => tracing::debug!("a connection was ended after {LONGEST_CONNECTION:?}"),
            }
            // Owned by this task: its place is free again only when the connection has ended.
            drop(permit);
        });
    }
    // New clients are refused from here on, while the open requests are answered.
    drop(listener);
    tokio::select! {
        () = graceful.shutdown() => {}
        () = tokio::time::sleep(PATIENCE) => tell("some connections were still open"),
    }
    Ok(())
}

/// The next connection, once the number of open ones permits it.
async fn accept(
    listener: &TcpListener,
    room: &Arc<Semaphore>,
) -> std::io::Result<(TcpStream, OwnedSemaphorePermit)> {
    let permit = room
        .clone()
        .acquire_owned()
        .await
        .map_err(std::io::Error::other)?;
    Ok((listener.accept().await?.0, permit))
}

/// Waits for Ctrl-C or a termination signal. It listens from the call on, so a caller that has read
/// the address may stop the server.
#[cfg(unix)]
fn stopped() -> impl Future<Output = ()> {
    use tokio::signal::unix::{SignalKind, signal};
    let signals = [SignalKind::interrupt(), SignalKind::terminate()].map(signal);
    async move {
        let [interrupted, terminated] = signals.map(|signal| async {
            match signal {
                Ok(mut signal) => signal.recv().await,
                // Without that signal there is nothing to wait for.
                Err(_) => std::future::pending().await,
            }
        });
        tokio::select! {
            _ = interrupted => {}
            _ = terminated => {}
        }
    }
}

/// Waits for Ctrl-C.
#[cfg(not(unix))]
async fn stopped() {
    if tokio::signal::ctrl_c().await.is_err() {
        std::future::pending::<()>().await;
    }
}

fn respond(service: &Service, request: &Request<Incoming>) -> Response<Full<Bytes>> {
    // The working memory of searches, one for each thread and reused without locks: an answer is
    // computed without an await.
    thread_local! {
        static MEMORY: RefCell<ServiceMemory> = RefCell::default();
    }
    let (status, body) = match *request.method() {
        // hyper leaves out the body of an answer to HEAD.
        Method::GET | Method::HEAD => {
            let target = request
                .uri()
                .path_and_query()
                .map_or("/", |target| target.as_str());
            let answer = MEMORY.with_borrow_mut(|memory| service.answer(target, memory));
            (
                StatusCode::from_u16(answer.status).unwrap_or(StatusCode::OK),
                answer.body,
            )
        }
        // Browsers ask first whether a page of another origin may send its request (CORS).
        Method::OPTIONS => (StatusCode::NO_CONTENT, Vec::new()),
        _ => {
            let body =
                r#"{"message":"only GET, HEAD and OPTIONS are answered","code":"InvalidMethod"}"#;
            (StatusCode::METHOD_NOT_ALLOWED, body.into())
        }
    };
    let mut response = Response::new(Full::new(Bytes::from(body)));
    *response.status_mut() = status;
    let headers = response.headers_mut();
    // The headers of osrm-routed, so that its clients work unchanged.
    for (name, value) in [
        (header::ACCESS_CONTROL_ALLOW_ORIGIN, "*"),
        (header::ACCESS_CONTROL_ALLOW_METHODS, "GET, HEAD, OPTIONS"),
        (
            header::ACCESS_CONTROL_ALLOW_HEADERS,
            "X-Requested-With, Content-Type",
        ),
        (header::CONTENT_TYPE, "application/json; charset=UTF-8"),
        (
            header::CONTENT_DISPOSITION,
            "inline; filename=\"response.json\"",
        ),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}
