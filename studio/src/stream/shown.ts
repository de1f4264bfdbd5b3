// What of a model is shown; kept with the settings of the studio.

export interface StreamShown {
  surface: boolean;
  /** Edges of all quads. */
  wire: boolean;
  /** The streamlines of the rows of tangents. */
  streamlines: boolean;
  /** All refined streamlines. */
  fine: boolean;
  arrows: boolean;
  /** Points of the initial curve, which can be dragged. */
  initial: boolean;
  combs: boolean;
  /** Great arcs between consecutive tangents. */
  arcs: boolean;
  /** Refined tangents on the sphere. */
  curves: boolean;
  /** Whether sphere and scene turn together. */
  linked: boolean;
  /** Which tangents the sphere shows: of one row or column, or all. */
  sphere: "row" | "column" | "all";
  /** Relative to what suits the model. */
  arrowSize: number;
  combSize: number;
}

export const STREAM_SHOWN: StreamShown = {
  surface: true,
  wire: false,
  streamlines: true,
  fine: false,
  arrows: true,
  initial: false,
  combs: false,
  arcs: true,
  curves: true,
  linked: true,
  sphere: "row",
  arrowSize: 1,
  combSize: 1,
};
