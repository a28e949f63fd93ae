/// The sky behind a scene: the picture that it was baked under.
import { EquirectangularReflectionMapping, MathUtils } from "three";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";

export class Sky {
    /// Null where there is no such picture.
    static async load(url, world) {
        const picture = await new HDRLoader().loadAsync(url).catch(() => null);
        return picture && new Sky(picture, world);
    }

    constructor(picture, world) {
        this.world = world;
        this.strength = this.exposure = 1;
        picture.mapping = EquirectangularReflectionMapping;
        world.background = picture;
    }

    /// @param degrees counter-clockwise from above, as `--env-rotate` has it
    turn(degrees, strength) {
        this.world.backgroundRotation.y = MathUtils.degToRad(degrees);
        this.strength = strength;
        this.expose(this.exposure);
    }

    expose(exposure) {
        this.exposure = exposure;
        this.world.backgroundIntensity = exposure * this.strength;
    }
}
