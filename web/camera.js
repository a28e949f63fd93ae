/// Where a scene is looked at from: a camera of the file, or one that sees all of it; and what the visitor makes of it.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/// All of the scene from the front, a little above, as `resolvent render` sees a scene that has no camera.
function frame(root) {
    const center = new THREE.Box3().setFromObject(root, true).getCenter(new THREE.Vector3());
    const place = new THREE.Vector3();
    let radius = 1e-6;
    root.traverse((node) => {
        for (let k = 0; k < (node.geometry?.getAttribute("position")?.count ?? 0); k++)
            radius = Math.max(radius, node.localToWorld(node.getVertexPosition(k, place)).distanceTo(center));
    });
    const camera = new THREE.PerspectiveCamera(45, 1, radius / 500, 100 * radius);
    const distance = 1.05 * radius / Math.sin(Math.PI / 8);
    camera.position.copy(center).addScaledVector(new THREE.Vector3(0, 0.35, 1).normalize(), distance);
    camera.lookAt(center);
    camera.updateMatrixWorld();
    return camera;
}

/// @param root of a scene whose matrices are up to date
export function findCamera(root) {
    let camera;
    root.traverse((node) => { if (node.isPerspectiveCamera) camera ??= node; });
    return camera ?? frame(root);
}

/// A camera where the scene's is, and controls that lead it around what lies before it.
export function createCamera(scene, renderer) {
    const camera = new THREE.PerspectiveCamera().copy(scene.camera, false);
    scene.camera.matrixWorld.decompose(camera.position, camera.quaternion, camera.scale);
    const middle = new THREE.Box3().setFromObject(scene.root).getCenter(new THREE.Vector3());
    const ahead = new THREE.Vector3(0, 0, -1).applyQuaternion(camera.quaternion);
    const controls = new OrbitControls(camera, renderer.domElement);
    controls.target.copy(camera.position).addScaledVector(ahead, camera.position.distanceTo(middle));
    controls.update();
    controls.saveState();
    return { camera, controls };
}

/// Fits a picture of some aspect into the view, as the browser fits the still: by its height, by its width if the view is narrower.
/// @param fov of the picture, vertical, degrees
export function fitView(camera, fov, aspect, width, height) {
    camera.aspect = width / height;
    const widened = Math.max(1, aspect / camera.aspect);
    camera.fov = 2 * THREE.MathUtils.radToDeg(Math.atan(widened * Math.tan(THREE.MathUtils.degToRad(fov) / 2)));
    camera.updateProjectionMatrix();
}
