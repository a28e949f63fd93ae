/// What metal and glass mirror: the scene as it is lit now, from where the camera began.
import { PMREMGenerator } from "three";

/// After a change of the light, how long to wait for the next, milliseconds.
const REST = 200;

export class Reflections {
    #timer;
    #target;

    constructor(renderer, world, scene, place) {
        Object.assign(this, { renderer, world, scene, place });
    }

    /// Light has changed: `done` is called once mirrors show it.
    follow(done) {
        if (!this.scene.mirrors.length) return;
        clearTimeout(this.#timer);
        this.#timer = setTimeout(() => { this.update(); done(); }, REST);
    }

    dispose() {
        clearTimeout(this.#timer);
        this.#target?.dispose();
    }

    update() {
        clearTimeout(this.#timer);
        const { scene: { mirrors, exposure }, world } = this;
        if (!mirrors.length) return;
        const generator = new PMREMGenerator(this.renderer), exposed = exposure.value;
        let target;
        exposure.value = 1; // what is mirrored is exposed where it is seen
        world.backgroundIntensity /= exposed;
        for (const mesh of mirrors) mesh.visible = false;
        try {
            target = generator.fromScene(world, 0, 0.01, 1000, { position: this.place });
        } finally {
            for (const mesh of mirrors) mesh.visible = true;
            exposure.value = exposed;
            world.backgroundIntensity *= exposed;
        }
        world.environment = target.texture;
        this.#target?.dispose();
        this.#target = target;
        generator.dispose();
    }
}
