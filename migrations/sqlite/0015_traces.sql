-- The trace, in the form of W3C Trace Context, in which a job was asked for.
ALTER TABLE jobs ADD COLUMN trace TEXT;
