-- Whose blobs the database's are: the blobs keep the same token, and those of another database are not touched.
CREATE TABLE identity (token TEXT NOT NULL);
INSERT INTO identity VALUES (lower(hex(randomblob(16))));

-- The blob with the geometry of a shape. Since this version it is the shape's own, as its file is, so that it goes with its
-- row whatever others do at the same time; blobs of before are shared by the uploads of one content.
ALTER TABLE shapes ADD COLUMN geometry_blob TEXT NOT NULL DEFAULT '';
UPDATE shapes SET geometry_blob = 'shapes/' || geometry || '.safetensors';
CREATE INDEX shapes_by_geometry_blob ON shapes (geometry_blob);
DROP INDEX shapes_by_geometry;

-- What one of all nodes is doing, until the lease runs out.
CREATE TABLE claims (
    name     TEXT PRIMARY KEY,
    holder   TEXT NOT NULL,
    until_ms BIGINT NOT NULL
);

-- Of many nodes that check, none is to take away the rows of another.
ALTER TABLE checks ADD COLUMN created_ms BIGINT NOT NULL DEFAULT 0;
