import { defineConfig } from "vite";

// Scenes and the runtime are put beside the page by `./dev web`; nothing of them is bundled.
export default defineConfig({
    base: "./",
    build: { outDir: "../out/web", emptyOutDir: false, target: "esnext", chunkSizeWarningLimit: 1500 },
});
