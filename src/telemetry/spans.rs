//! The spans of this process, sent to a collector of OpenTelemetry.

use std::env;

use anyhow::Context;
use opentelemetry::trace::TracerProvider;
use opentelemetry_otlp::SpanExporter;
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::SdkTracerProvider;
use sketchmatch::tls;
use tracing::{Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::registry::LookupSpan;

/// Variables of the environment, of OpenTelemetry, that name a collector.
const COLLECTORS: [&str; 2] = ["OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT"];

/// Sends spans as long as it lives; dropped, it sends what waits.
pub struct Exporter(SdkTracerProvider);

impl Drop for Exporter {
    fn drop(&mut self) {
        if let Err(error) = self.0.shutdown() {
            tracing::warn!(%error, "the last spans were not sent");
        }
    }
}

/// What takes spans, where the environment names a collector. Called outside of a runtime, for the exporter has threads of its
/// own.
///
/// # Errors
/// A collector's address that cannot be read.
pub fn layer<S>() -> anyhow::Result<Option<(impl Layer<S>, Exporter)>>
where
    S: Subscriber + for<'span> LookupSpan<'span>,
{
    if !COLLECTORS.iter().any(|name| env::var_os(name).is_some_and(|value| !value.is_empty())) {
        return Ok(None);
    }
    tls::provide();
    let exporter =
        SpanExporter::builder().with_http().build().context("spans cannot be sent as the environment says")?;
    let resource = Resource::builder().with_service_name("sketchmatch").build();
    let provider = SdkTracerProvider::builder().with_batch_exporter(exporter).with_resource(resource).build();
    let spans = Targets::new().with_target("sketchmatch", Level::DEBUG);
    let layer = tracing_opentelemetry::layer().with_tracer(provider.tracer("sketchmatch")).with_filter(spans);
    Ok(Some((layer, Exporter(provider))))
}
