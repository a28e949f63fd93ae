/// What the visitor changes: strength and colour of every light, and how the sky is turned.
import { Color } from "three";

function input(properties) {
    return Object.assign(document.createElement("input"), properties);
}

function addRow(panel, ...contents) {
    const label = document.createElement("label");
    label.append(...contents);
    panel.append(label);
}

/// @param show (scales, degrees): called at once and after every change; scales as LightBasis.relight takes them
export function addControls(panel, basis, show) {
    const scales = basis.names.map(() => [1, 1, 1]);
    const angle = input({ id: "turn", type: "range", min: 0, max: 360, step: "any", value: basis.rotation });
    const update = () => show(scales, Number(angle.value));
    basis.names.forEach((light, index) => {
        const strength = input({ type: "range", min: 0, max: 4, step: 0.01, value: 1 });
        const color = input({ type: "color", value: "#ffffff", ariaLabel: `Colour of ${light}` });
        strength.dataset.light = light;
        strength.oninput = color.oninput = () => {
            scales[index] = new Color(color.value).toArray().map((c) => c * strength.value);
            update();
        };
        addRow(panel, light, strength, color);
    });
    if (basis.turns > 1) {
        angle.oninput = update;
        addRow(panel, "Sky turned", angle);
        addRow(panel, letDaysGoBy(angle, update), "Day and night");
    }
    update();
}

/// A box to tick: the sky turns by itself, once in twelve seconds.
function letDaysGoBy(angle, update) {
    const box = input({ type: "checkbox" });
    let before;
    const step = (now) => {
        if (!box.checked) return;
        angle.value = (Number(angle.value) + 0.03 * (now - before)) % 360;
        before = now;
        update();
        requestAnimationFrame(step);
    };
    box.onchange = () => { before = performance.now(); step(before); };
    return box;
}
