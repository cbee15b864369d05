// A reader of the report's page: uses it through DOM events and tells the frame around it what came of that.

addEventListener("load", async () => {
  const seen = {};
  const all = (selector) => [...document.querySelectorAll(selector)];
  const one = (selector) => document.querySelector(selector);
  const choose = (id, value) => {
    one(id).value = value;
    one(id).dispatchEvent(new Event("change"));
  };
  const frames = async (count) => {
    while (count-- > 0) await new Promise((done) => setTimeout(done, 50));
  };
  try {
    await frames(4);
    const stage = one("#stage"), divider = one("#divider"), images = all("#stage img");
    seen.width = document.documentElement.clientWidth;
    seen.title = one("h1").textContent;
    seen.loaded = images.map((image) => image.complete && image.naturalWidth === 64);

    // A pointer that is made up cannot be captured; the browser would refuse.
    stage.setPointerCapture = () => {};
    const box = stage.getBoundingClientRect();
    const pointer = (type, target, share) =>
      target.dispatchEvent(new PointerEvent(type, { bubbles: true, pointerId: 7, button: 0, clientX: box.left + share * box.width, clientY: box.top + 20 }));
    const now = () => divider.getAttribute("aria-valuenow");
    seen.slider = [now()];
    pointer("pointerdown", divider, 0.5);
    pointer("pointermove", stage, 0.25);
    pointer("pointerup", stage, 0.25);
    seen.slider.push(now());
    divider.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
    seen.slider.push(now());
    seen.cut = getComputedStyle(one("#pane-b")).clipPath;

    // Twice as large about the middle, then dragged.
    stage.dispatchEvent(new WheelEvent("wheel", { deltaY: -Math.log(2) / 0.002, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2, bubbles: true, cancelable: true }));
    pointer("pointerdown", stage, 0.5);
    pointer("pointermove", stage, 0.4);
    pointer("pointerup", stage, 0.4);
    seen.zoomed = images.map((image) => image.style.transform);
    one("#fit").click();
    seen.fitted = images[0].style.transform;
    choose("#layout", "beside");
    seen.beside = one("#pane-a").clientWidth / stage.clientWidth;
    const picture = images[1].src;
    choose("#view", "heat");
    seen.heat = images[1].src !== picture && images[1].src.startsWith("data:image/png") && !one("#scale").hidden;
    choose("#view", "picture");

    const points = all(".point");
    seen.points = points.length;
    seen.fronts = all(".front").length;
    seen.axis = all(".axes text").map((label) => label.textContent);
    points[3].dispatchEvent(new PointerEvent("pointerenter"));
    seen.tip = one("#tip").hidden ? "" : one("#tip").textContent;
    seen.chosen = points[3].getAttribute("aria-label").split(":")[0];
    points[3].dispatchEvent(new MouseEvent("click", { bubbles: true }));
    seen.shown = one("#picture-b").value;

    const header = (name) => all("#rows th").find((th) => th.textContent === name);
    const column = (name) => {
      const index = all("#rows th").indexOf(header(name));
      return all("#rows tbody tr").map((row) => parseFloat(row.cells[index].textContent));
    };
    header("tracer").firstChild.click();
    header("ms").firstChild.click();
    seen.times = column("ms");
    header("ms").firstChild.click();
    seen.times_down = column("ms");
    seen.sorted_by = ["ms", "tracer"].map((name) => header(name).getAttribute("aria-sort"));
    choose("#table-reference", "");
    seen.both = all("#rows tbody tr").length;
    choose("#table-reference", "bvh");
    one("#filter").value = "LBVH";
    one("#filter").dispatchEvent(new Event("input"));
    seen.filtered = all("#rows tbody tr").length;
    await frames(2);
    seen.overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    seen.ran = window.ran === 1;
  } catch (error) {
    window.heard.push(String(error.stack));
  }
  seen.errors = window.heard;
  parent.postMessage(JSON.stringify(seen), "*");
});
