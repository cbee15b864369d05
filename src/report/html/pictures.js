// Two pictures under one pan and zoom: split by a divider, or side by side; as they are, their errors, or their difference.

const stage = byId("stage"), divider = byId("divider");
const sides = ["a", "b"].map((side) => ({
  select: byId(`picture-${side}`),
  pane: byId(`pane-${side}`),
  image: byId(`pane-${side}`).querySelector("img"),
}));
// Screen pixels per picture pixel relative to fitting, and where the picture's corner is within its pane.
const look = { zoom: 1, x: 0, y: 0, split: 50 };
const MOST_ZOOM = 40;

const pictureById = new Map(report.pictures.map((picture) => [picture.id, picture]));
const pictureOfRow = (row) => report.pictures.find((picture) => picture.file === row.image);

if (report.pictures.length) {
  for (const { select } of sides) options(select, report.pictures.map(({ id }) => [id, id]));
  const first = report.pictures[0], rendered = report.pictures.find((picture) => !picture.reference);
  sides[0].select.value = first.id;
  sides[1].select.value = (rendered ?? report.pictures.at(-1)).id;
  for (const { select } of sides) select.addEventListener("change", loadPictures);
  for (const id of ["view", "layout"]) byId(id).addEventListener("change", loadPictures);
  stage.style.setProperty("--aspect", `${report.display_size[0]} / ${report.display_size[1]}`);
  loadPictures();
} else {
  byId("pictures").hidden = true;
}

/** Opens a row's picture on side B. */
function showPicture(row) {
  const picture = pictureOfRow(row);
  if (!picture) return;
  sides[1].select.value = picture.id;
  loadPictures();
  byId("pictures").scrollIntoView({ block: "nearest" });
}

function loadPictures() {
  const view = byId("view").value;
  const missing = [];
  for (const { select, image } of sides) {
    const picture = pictureById.get(select.value);
    const file = view === "heat" ? picture.heat : picture.file;
    const address = data.images[file];
    // An image without a source would be drawn as broken.
    image.hidden = !address;
    if (address) image.src = address;
    image.alt = `${view === "heat" ? "Error of " : ""}${picture.id}`;
    if (!address) missing.push(picture.id);
  }
  byId("missing").hidden = !missing.length;
  byId("missing").textContent = `No map of the error of ${missing.join(" and ")}.`;
  byId("scale").hidden = view !== "heat";
  stage.dataset.view = view;
  stage.dataset.layout = view === "difference" ? "over" : byId("layout").value;
  place();
}

/** Puts both pictures where the look says. */
function place() {
  const { clientWidth: width, clientHeight: height } = sides[0].pane;
  look.x = Math.min(0, Math.max(look.x, width * (1 - look.zoom)));
  look.y = Math.min(0, Math.max(look.y, height * (1 - look.zoom)));
  for (const { image } of sides) {
    image.style.transform = `translate(${look.x}px, ${look.y}px) scale(${look.zoom})`;
    // Pixels stay squares once they are larger than the screen's.
    image.style.imageRendering = look.zoom * width > image.naturalWidth * 1.5 ? "pixelated" : "auto";
  }
  stage.style.setProperty("--split", `${look.split}%`);
  divider.setAttribute("aria-valuenow", Math.round(look.split));
}

/** Zooms so that the point of the pane stays where it is. */
function zoomAt(factor, x, y) {
  const zoom = Math.min(MOST_ZOOM, Math.max(1, look.zoom * factor)), ratio = zoom / look.zoom;
  look.x = x - (x - look.x) * ratio;
  look.y = y - (y - look.y) * ratio;
  look.zoom = zoom;
  place();
}

function zoomMiddle(factor) {
  const { clientWidth, clientHeight } = sides[0].pane;
  zoomAt(factor, clientWidth / 2, clientHeight / 2);
}

function fit() {
  Object.assign(look, { zoom: 1, x: 0, y: 0 });
  place();
}

function moveDivider(split) {
  look.split = Math.min(100, Math.max(0, split));
  place();
}

/** A pointer's place within the pane that it is over, so that side by side both count alike. */
function inPane(event) {
  const panes = sides.map(({ pane }) => pane.getBoundingClientRect());
  const box = panes.findLast((b) => event.clientX >= b.left && event.clientY >= b.top) ?? panes[0];
  return [event.clientX - box.left, event.clientY - box.top];
}

stage.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoomAt(Math.exp(-event.deltaY * 0.002), ...inPane(event));
}, { passive: false });

// One pointer pans or holds the divider, two pinch.
const pointers = new Map();
let holding = null;

stage.addEventListener("pointerdown", (event) => {
  if (event.button !== 0) return;
  holding = pointers.size ? "pictures" : event.target === divider ? "divider" : "pictures";
  pointers.set(event.pointerId, event);
  stage.setPointerCapture(event.pointerId);
});
stage.addEventListener("pointermove", (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return readPixel(event);
  if (holding === "divider") {
    const box = stage.getBoundingClientRect();
    moveDivider(((event.clientX - box.left) / box.width) * 100);
  } else if (pointers.size === 1) {
    look.x += event.clientX - before.clientX;
    look.y += event.clientY - before.clientY;
    place();
  } else {
    const other = [...pointers.values()].find((p) => p.pointerId !== event.pointerId);
    const distance = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
    zoomAt(distance(event) / Math.max(1, distance(before)), ...inPane(other));
  }
  pointers.set(event.pointerId, event);
});
for (const end of ["pointerup", "pointercancel"]) {
  stage.addEventListener(end, (event) => pointers.delete(event.pointerId) && pointers.size === 0 && (holding = null));
}
stage.addEventListener("dblclick", fit);
byId("fit").addEventListener("click", fit);
divider.addEventListener("keydown", (event) => {
  const by = { ArrowLeft: -2, ArrowDown: -2, ArrowRight: 2, ArrowUp: 2, Home: -100, End: 100 }[event.key];
  if (by === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  moveDivider(look.split + by);
});
stage.addEventListener("keydown", (event) => {
  const pan = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[event.key];
  if (pan) {
    look.x += pan[0];
    look.y += pan[1];
    place();
  } else if (event.key === "+" || event.key === "=") zoomMiddle(1.5);
  else if (event.key === "-") zoomMiddle(1 / 1.5);
  else if (event.key === "0") fit();
  else return;
  event.preventDefault();
});
new ResizeObserver(() => requestAnimationFrame(place)).observe(stage);

const probe = element("canvas", { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });

/** The display codes of both pictures under the pointer. */
function readPixel(event) {
  const [left, top] = inPane(event);
  const { clientWidth, clientHeight } = sides[0].pane;
  const words = sides.map(({ image }, i) => {
    const { naturalWidth: width, naturalHeight: height } = image;
    const x = Math.floor(((left - look.x) / look.zoom / clientWidth) * width);
    const y = Math.floor(((top - look.y) / look.zoom / clientHeight) * height);
    if (image.hidden || !image.complete || !(x >= 0 && y >= 0 && x < width && y < height)) return null;
    probe.clearRect(0, 0, 1, 1);
    probe.drawImage(image, x, y, 1, 1, 0, 0, 1, 1);
    const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
    return `${"AB"[i]} (${x}, ${y}): ${r} ${g} ${b}`;
  });
  if (words.every(Boolean)) byId("pixel").textContent = `8-bit sRGB at ${words.join(" · ")} · ${digits(look.zoom)}×`;
}
