-- The sizes of a shape, by which memory and limits are weighed, in columns of their own. Earlier versions had them in what is
-- told of the shape alone.
ALTER TABLE shapes ADD COLUMN vertices BIGINT NOT NULL DEFAULT 0;
ALTER TABLE shapes ADD COLUMN triangles BIGINT NOT NULL DEFAULT 0;
UPDATE shapes SET
    vertices = COALESCE(json_extract(body, '$.vertices'), 0),
    triangles = COALESCE(json_extract(body, '$.triangles'), 0);
