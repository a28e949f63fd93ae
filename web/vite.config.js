import { defineConfig } from "vite";

// Scenes and the runtime are put beside the page by `./dev web`; nothing of them is bundled.
// Isolated pages may share memory among threads, which the solver uses.
const isolated = { "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp" };

export default defineConfig({
    base: "./",
    preview: { headers: isolated },
    build: { outDir: "../out/web", emptyOutDir: false, target: "esnext", chunkSizeWarningLimit: 1500 },
});
