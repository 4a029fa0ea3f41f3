//! Of which trace a piece of work is part, in the words of W3C Trace Context (`traceparent`): what a job is asked for in is kept
//! with it, so that whoever carries it out goes on with the same trace.
//!
//! Without the feature `otel` a trace is the client's, passed on as it came; with it the spans of this process take part.

use tracing::Span;

/// Makes `span` part of the trace that `parent` tells of.
#[cfg(feature = "otel")]
pub fn join(span: &Span, parent: &str) {
    use std::collections::HashMap;

    use opentelemetry::propagation::TextMapPropagator;
    use opentelemetry_sdk::propagation::TraceContextPropagator;
    use tracing_opentelemetry::OpenTelemetrySpanExt;

    let carrier = HashMap::from([("traceparent".to_owned(), parent.to_owned())]);
    // It fails where nobody takes part, which is no matter.
    let _ = span.set_parent(TraceContextPropagator::new().extract(&carrier));
}

#[cfg(not(feature = "otel"))]
pub fn join(_: &Span, _: &str) {}

/// What tells others of the trace that `span` is part of, where it is part of one.
#[cfg(feature = "otel")]
pub fn of(span: &Span) -> Option<String> {
    use std::collections::HashMap;

    use opentelemetry::propagation::TextMapPropagator;
    use opentelemetry_sdk::propagation::TraceContextPropagator;
    use tracing_opentelemetry::OpenTelemetrySpanExt;

    let mut carrier = HashMap::new();
    TraceContextPropagator::new().inject_context(&span.context(), &mut carrier);
    carrier.remove("traceparent")
}

#[cfg(not(feature = "otel"))]
pub fn of(_: &Span) -> Option<String> {
    None
}
