-- A shape is an upload: a file, its media type and what was asked of the reading. `geometry` names the blob with what was
-- read, which uploads of the same geometry share, and `file` the blob with the bytes as they came. What was uploaded
-- before was named by its geometry, and its file was not kept.
ALTER TABLE shapes ADD COLUMN geometry TEXT NOT NULL DEFAULT '';
ALTER TABLE shapes ADD COLUMN file TEXT;
ALTER TABLE shapes ADD COLUMN media_type TEXT;
UPDATE shapes SET geometry = id;
CREATE INDEX shapes_by_geometry ON shapes (geometry);
CREATE INDEX shapes_by_file ON shapes (file) WHERE file IS NOT NULL;
