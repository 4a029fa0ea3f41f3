//! The page at `/`, built in or not.

use bytes::Bytes;
use sketchmatch::http::{Config, FrontPage};

use crate::server::{Server, header, problem_of};

const PAGE: &str = "<!doctype html><title>page</title>";
const SCRIPT: &str = "console.log('page')";

/// A server whose page is these files.
async fn serving(files: &[(&str, &'static str)]) -> Server {
    let files = files.iter().map(|&(path, text)| (path.to_owned(), Bytes::from_static(text.as_bytes())));
    Server::idle(Config { front_page: FrontPage::of(files), ..Config::default() }).await
}

#[tokio::test(flavor = "multi_thread")]
async fn the_page_is_at_the_root_and_may_load_nothing_from_elsewhere() {
    let server = serving(&[("index.html", PAGE), ("assets/index-1a2b.js", SCRIPT)]).await;
    let page = server.get("/").send().await.unwrap();
    assert_eq!((page.status().as_u16(), header(&page, "content-type")), (200, "text/html; charset=utf-8"));
    assert_eq!(header(&page, "cache-control"), "no-cache");
    assert_eq!(header(&page, "x-content-type-options"), "nosniff");
    assert_eq!(header(&page, "referrer-policy"), "no-referrer");
    let policy = header(&page, "content-security-policy").to_owned();
    let allowed = |directive: &str| {
        let found = policy.split("; ").find_map(|part| part.strip_prefix(directive)?.strip_prefix(' '));
        found.unwrap_or_else(|| panic!("{directive}: {policy}")).to_owned()
    };
    assert_eq!((allowed("default-src").as_str(), allowed("script-src").as_str()), ("'none'", "'self'"));
    assert_eq!((allowed("style-src").as_str(), allowed("connect-src").as_str()), ("'self'", "'self'"));
    assert_eq!((allowed("img-src").as_str(), allowed("frame-ancestors").as_str()), ("'self' blob:", "'none'"));
    assert!(!policy.contains("unsafe") && !policy.contains("http"), "{policy}");
    let tag = header(&page, "etag").to_owned();
    assert_eq!(page.text().await.unwrap(), PAGE);
    let again = server.get("/").header("if-none-match", tag).send().await.unwrap();
    assert_eq!((again.status().as_u16(), header(&again, "cache-control")), (304, "no-cache"));
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_page_is_made_of_never_changes() {
    let long: &'static str = Box::leak(SCRIPT.repeat(100).into_boxed_str());
    let server =
        serving(&[("index.html", PAGE), ("assets/index-1a2b.js", long), ("assets/icon-3c.svg", "<svg/>")]).await;
    let script = server.get("/assets/index-1a2b.js").header("accept-encoding", "gzip").send().await.unwrap();
    assert_eq!((script.status().as_u16(), header(&script, "content-type")), (200, "text/javascript; charset=utf-8"));
    assert!(header(&script, "cache-control").contains("max-age=31536000, immutable"));
    assert_eq!((header(&script, "content-encoding"), header(&script, "x-content-type-options")), ("gzip", "nosniff"));
    assert!(script.bytes().await.unwrap().len() < long.len() / 4);
    let icon = server.get("/assets/icon-3c.svg").send().await.unwrap();
    assert_eq!(header(&icon, "content-type"), "image/svg+xml");
    for path in ["/assets/index-0000.js", "/assets/index.html", "/assets/..%2Findex.html", "/assets/", "/index.html"] {
        problem_of(server.get(path).send().await.unwrap(), 404).await;
    }
    problem_of(server.post("/").send().await.unwrap(), 405).await;
    problem_of(server.get("/licences").send().await.unwrap(), 404).await;
    let licences = serving(&[("licences.md", "MIT")]).await.get("/licences").send().await.unwrap();
    assert_eq!(header(&licences, "content-type"), "text/plain; charset=utf-8");
    assert_eq!(licences.text().await.unwrap(), "MIT");
}

#[tokio::test(flavor = "multi_thread")]
async fn without_a_page_the_root_says_how_to_get_it() {
    let server = serving(&[]).await;
    let answer = server.get("/").send().await.unwrap();
    assert_eq!((answer.status().as_u16(), header(&answer, "content-type")), (200, "text/plain; charset=utf-8"));
    let text = answer.text().await.unwrap();
    assert!(text.contains("make web") && text.contains("/docs"), "{text}");
    problem_of(server.get("/assets/index.js").send().await.unwrap(), 404).await;
    assert_eq!(server.get("/docs/").send().await.unwrap().status(), 200);
}
