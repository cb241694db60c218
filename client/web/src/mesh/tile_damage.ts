// What is wrong with a tile, in one sentence.
export class TileDamage extends Error {}
