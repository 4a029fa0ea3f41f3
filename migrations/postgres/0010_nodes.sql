-- As SQLite's migration of this number.
CREATE TABLE identity (token TEXT NOT NULL);
INSERT INTO identity VALUES (replace(gen_random_uuid()::text, '-', ''));

ALTER TABLE shapes ADD COLUMN geometry_blob TEXT NOT NULL DEFAULT '';
UPDATE shapes SET geometry_blob = 'shapes/' || geometry || '.safetensors';
CREATE INDEX shapes_by_geometry_blob ON shapes (geometry_blob);
CREATE INDEX shapes_by_file ON shapes (file) WHERE file IS NOT NULL;

CREATE TABLE claims (
    name     TEXT PRIMARY KEY,
    holder   TEXT NOT NULL,
    until_ms BIGINT NOT NULL
);

ALTER TABLE checks ADD COLUMN created_ms BIGINT NOT NULL DEFAULT 0;

-- Tells every node of a change of a job: by which node, which job, and its state. Beats that change nothing tell nothing.
CREATE FUNCTION tell_of_job() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    told jobs%ROWTYPE := CASE TG_OP WHEN 'DELETE' THEN OLD ELSE NEW END;
    state TEXT := CASE TG_OP WHEN 'DELETE' THEN 'gone' ELSE told.state END;
BEGIN
    PERFORM pg_notify('sketchmatch_' || TG_TABLE_SCHEMA, concat_ws(' ', current_setting('application_name'), told.id, state));
    RETURN NULL;
END $$;
CREATE TRIGGER tell_of_new_job AFTER INSERT OR DELETE ON jobs FOR EACH ROW EXECUTE FUNCTION tell_of_job();
CREATE TRIGGER tell_of_changed_job AFTER UPDATE ON jobs FOR EACH ROW
    WHEN (OLD.revision IS DISTINCT FROM NEW.revision) EXECUTE FUNCTION tell_of_job();
