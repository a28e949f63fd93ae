import type { AnimationClip, Camera, ColorRepresentation, Group } from "three";

/** A file of `resolvent bake --to vertex|lightmap --basis`, relit when its lights change. */
export class RelightableScene {
    /**
     * @param url of the .glb
     * @param basisUrl default: NAME.light.safetensors beside it
     * @throws Error that says what is missing or does not fit
     */
    static load(url: string, basisUrl?: string): Promise<RelightableScene>;
    /** The same of bytes. */
    static parse(file: ArrayBuffer, basis: ArrayBuffer, module?: BufferSource): Promise<RelightableScene>;
    readonly root: Group;
    readonly animations: AnimationClip[];
    readonly camera: Camera | null;
    /** Multiplies what is shown, before tone mapping. */
    readonly exposure: { value: number };
    readonly lights: string[];
    readonly milliseconds: number;
    /** @param strength relative to the bake; 0 = off */
    setLight(name: string, strength: number, color?: ColorRepresentation): void;
    /** Turns the surroundings, if they were baked with --env-turns. */
    turnSky(degrees: number): void;
    /** Relights if something has changed; returns whether it had. */
    update(): boolean;
    dispose(): void;
}
