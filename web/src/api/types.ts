/** The types of the interface by the names the page uses; `schema.d.ts` is made from openapi/openapi.json. */
import type { components } from "./schema";

type Schemas = components["schemas"];

export type Alternative = Schemas["Alternative"];
export type Evaluation = Schemas["Evaluation"];
export type Example = Schemas["ExampleDocument"];
export type Geometry = Schemas["Geometry"];
export type Known = Schemas["Known"];
export type Match = Schemas["MatchDocument"];
export type MatchRequest = Schemas["MatchRequest"];
export type Matrix = Schemas["Matrix"];
export type MeshComponent = Schemas["MeshComponent"];
export type MeshDocument = Schemas["ShapeDocument_MeshMeasures"];
export type MeshListing = Schemas["Listing_ShapeDocument_MeshMeasures"];
export type Outline = Schemas["OutlineRequest"];
export type Parameter = Schemas["Parameter"];
export type Pose = Schemas["PoseDocument"];
export type PoseRequest = Schemas["PoseRequest"];
export type PoseResult = Schemas["PoseResult"];
export type Problem = Schemas["Problem"];
export type ProblemFault = Schemas["ProblemFault"];
export type Regulariser = Schemas["Description"];
export type Result = Schemas["MatchResult"];
export type SignedLinks = Schemas["SignedLinks"];
export type SketchDocument = Schemas["ShapeDocument_SketchMeasures"];
export type Ups = Schemas["Ups"];
export type View = Schemas["ViewReport"];
