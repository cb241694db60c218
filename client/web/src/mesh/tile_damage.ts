// Describes in one sentence what is wrong with a tile.
export class TileDamage extends Error {}
