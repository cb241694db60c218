// Describes in one sentence what is wrong with a tile.
export class TileError extends Error {}
