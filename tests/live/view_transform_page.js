// Prints what the page's view transforms make of colors. Arguments: view_transform.js and a JSON array of colors.
"use strict";
const fs = require("fs");
const [, , transforms, colors] = process.argv;
const views = new Function(fs.readFileSync(transforms, "utf8") + "\nreturn viewTransforms;")();
const shown = {};
for (const [name, view] of Object.entries(views)) {
    shown[name] = JSON.parse(fs.readFileSync(colors, "utf8")).map((color) => {
        const out = [0, 0, 0];
        view(...color.map((x) => x === null ? NaN : x), out);
        return out;
    });
}
console.log(JSON.stringify(shown));
