//! The window's life: events go to the panels, orders to the worker, pictures come back, the painter draws. Nothing here
//! waits for any of them.

mod files;

use crate::canvas::Canvas;
use crate::painter::Painter;
use crate::panels::{self, Desk, Screen};
use crate::script::{Request, Script, Turn};
use crate::session::Session;
use crate::shown::Shown;
use crate::store::Store;
use crate::widgets::Widgets;
use crate::worker::{Order, Worker};
use crate::{Failure, TITLE};
use egui::ViewportId;
use gridlight::RenderSettings;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// Pixels of the window at first: room for panels on both sides of a picture.
const SIZE: [u32; 2] = [1440, 900];

/// A script waits in steps of so long.
const LOOK_AGAIN: Duration = Duration::from_millis(15);

/// Another thread has something to tell.
enum Wake {
    Worker,
    Painter,
}

/// What the window is opened with.
pub struct Options {
    /// What is rendered first.
    pub settings: RenderSettings,
    /// Part of the adapter's name.
    pub adapter: Option<String>,
    /// Steps to do.
    pub script: Option<Script>,
    /// Pixels, if not as usual.
    pub size: Option<[u32; 2]>,
    /// Folder of shaders to follow.
    pub shaders: PathBuf,
}

/// Opens a window and lives in it until it is closed.
pub fn run(options: Options) -> Result<(), Failure> {
    let event_loop = EventLoop::<Wake>::with_user_event().build()?;
    let proxy = event_loop.create_proxy();
    let mut viewer = Viewer { options: Some(options), proxy, desk: None, failure: None };
    event_loop.run_app(&mut viewer)?;
    match viewer.failure {
        Some(failure) => Err(failure),
        None => Ok(()),
    }
}

/// What the event loop owns.
struct Viewer {
    options: Option<Options>,
    proxy: EventLoopProxy<Wake>,
    desk: Option<Open>,
    failure: Option<Failure>,
}

/// An open window with everything behind it.
struct Open {
    // The painter ends before the window that it draws.
    painter: Painter,
    context: egui::Context,
    input: egui_winit::State,
    screen: Screen,
    window: Arc<Window>,
    adapter: Option<String>,
    shaders: PathBuf,
    proxy: EventLoopProxy<Wake>,
    worker: Worker,
    ordered: Option<Order>,
    session: Session,
    shown: Shown,
    store: Store,
    script: Option<Script>,
    widgets: Widgets,
    /// The panels want to be drawn again as soon as they are drawn.
    moves_by_itself: bool,
    /// How long each event was worked on: what the next one had to wait.
    turns: Vec<Duration>,
}

/// How things go on after a frame of panels.
enum Next {
    Wait(Option<Instant>),
    Quit,
    Fail(Failure),
}

impl ApplicationHandler<Wake> for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(options) = self.options.take() {
            match Open::new(event_loop, options, &self.proxy) {
                Ok(open) => self.desk = Some(open),
                Err(failure) => self.end(event_loop, Some(failure)),
            }
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(open)) = (cause, &self.desk) {
            open.window.request_redraw();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        let Some(open) = &mut self.desk else { return };
        match wake {
            Wake::Worker => open.window.request_redraw(),
            // What moves by itself moves as fast as it can be drawn.
            Wake::Painter if std::mem::take(&mut open.moves_by_itself) => open.window.request_redraw(),
            Wake::Painter => {}
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let begun = Instant::now();
        let Some(open) = &mut self.desk else { return };
        let next = match event {
            WindowEvent::CloseRequested => Next::Quit,
            WindowEvent::RedrawRequested => open.frame(),
            event => {
                open.handle(&event);
                Next::Wait(None)
            }
        };
        open.turns.push(begun.elapsed());
        match next {
            Next::Wait(None) => {}
            Next::Wait(Some(until)) => event_loop.set_control_flow(ControlFlow::WaitUntil(until)),
            Next::Quit => self.end(event_loop, None),
            Next::Fail(failure) => self.end(event_loop, Some(failure)),
        }
    }
}

impl Viewer {
    fn end(&mut self, event_loop: &ActiveEventLoop, failure: Option<Failure>) {
        if let Some(open) = self.desk.take()
            && open.script.is_some()
        {
            println!("{}", turns(&open.turns));
        }
        self.failure = failure;
        event_loop.exit();
    }
}

/// What input had to wait. The first frame of panels draws the font, before there is anything to click on.
fn turns(all: &[Duration]) -> String {
    let longest = all.iter().max().copied().unwrap_or_default();
    let slow = all.iter().filter(|turn| turn.as_millis() >= 100).count();
    let longest_ms = longest.as_secs_f64() * 1e3;
    format!("{} turns of the event loop, {slow} of 100 ms or more, the longest {longest_ms:.0} ms", all.len())
}

fn worker(adapter: Option<String>, shaders: &Path, proxy: &EventLoopProxy<Wake>) -> std::io::Result<Worker> {
    let proxy = proxy.clone();
    Worker::start(
        adapter,
        Some(shaders),
        Box::new(move || {
            // A window that is gone needs no waking.
            let _ = proxy.send_event(Wake::Worker);
        }),
    )
}

impl Open {
    fn new(
        event_loop: &ActiveEventLoop,
        options: Options,
        proxy: &EventLoopProxy<Wake>,
    ) -> Result<Self, Failure> {
        let [width, height] = options.size.unwrap_or(SIZE);
        let attributes =
            Window::default_attributes().with_title(TITLE).with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(event_loop.create_window(attributes)?);
        let (painter, context, input) =
            look(&window, options.adapter.as_deref(), options.script.is_some(), proxy)?;
        window.request_redraw();
        Ok(Self {
            painter,
            context,
            input,
            screen: Screen::default(),
            window,
            worker: worker(options.adapter.clone(), &options.shaders, proxy)?,
            adapter: options.adapter,
            shaders: options.shaders,
            proxy: proxy.clone(),
            ordered: None,
            session: Session::new(options.settings),
            shown: Shown::default(),
            // A script finds the same panels on every machine.
            store: if options.script.is_some() { Store::default() } else { Store::of_user() },
            script: options.script,
            widgets: Widgets::default(),
            moves_by_itself: false,
            turns: Vec::new(),
        })
    }

    /// An event that is not a frame.
    fn handle(&mut self, event: &WindowEvent) {
        let response = self.input.on_window_event(&self.window, event);
        match event {
            WindowEvent::Resized(size) => self.painter.resize(*size),
            WindowEvent::DroppedFile(path) => self.open_file(path),
            _ => {}
        }
        if response.repaint || matches!(event, WindowEvent::Resized(_) | WindowEvent::DroppedFile(_)) {
            self.window.request_redraw();
        }
    }

    /// Takes in what the worker told.
    fn listen(&mut self) {
        while let Some(event) = self.worker.event() {
            let scene = self.shown.scene.as_ref().map(|facts| facts.settings.scene.clone());
            self.shown.take(event, &mut self.session);
            if let Some(facts) =
                self.shown.scene.as_ref().filter(|facts| Some(&facts.settings.scene) != scene.as_ref())
            {
                self.store.opened(&facts.settings.scene);
                self.window.set_title(&format!("{TITLE}: {}", facts.settings.scene));
            }
        }
        for message in self.painter.messages() {
            self.shown.say(message);
        }
        if self.worker.is_gone() {
            self.shown.say("the renderer stopped and is started again; see the terminal for why".into());
            match worker(self.adapter.clone(), &self.shaders, &self.proxy) {
                Ok(worker) => self.worker = worker,
                Err(e) => self.shown.say(format!("it cannot be: {e}")),
            }
            self.ordered = None;
        }
    }

    /// One frame of panels.
    fn frame(&mut self) -> Next {
        self.listen();
        let mut asked = None;
        let mut events = Vec::new();
        if let Some(script) = &mut self.script {
            match script.turn(&self.session, &self.shown, &self.widgets) {
                Turn::Events(more) => events = more,
                Turn::Ask(Request::Quit) => return Next::Quit,
                Turn::Ask(request) => asked = Some(request),
                Turn::Wait => {}
                Turn::Stuck(why) => return Next::Fail(why.into()),
            }
        }
        let mut input = self.input.take_egui_input(&self.window);
        input.events.extend(events);
        if input.screen_rect.is_none() {
            // Minimised: there is nothing to lay out in.
            return Next::Wait(None);
        }
        let mut actions = Vec::new();
        let mut desk = Desk {
            session: &mut self.session,
            shown: &mut self.shown,
            screen: &mut self.screen,
            store: &mut self.store,
            actions: &mut actions,
        };
        let context = self.context.clone();
        let mut full = context.run_ui(input, |ui| panels::show(ui, &mut desk));
        self.widgets = Widgets::of(full.platform_output.accesskit_update.as_ref());
        self.input.handle_platform_output(&self.window, full.platform_output);
        let shapes = self.context.tessellate(full.shapes, full.pixels_per_point);
        let mut screenshots = Vec::new();
        for action in actions {
            self.act(action, &mut screenshots);
        }
        if let Some(request) = asked {
            self.obey(request, &mut screenshots);
        }
        self.painter.draw(shapes, full.pixels_per_point, &mut full.textures_delta, screenshots);
        self.send_order();
        if self.painter.is_lost()
            && let Err(failure) = self.look_again()
        {
            return Next::Fail(failure);
        }
        let delay = full.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        if delay.is_zero() {
            self.moves_by_itself = true;
            if self.painter.has_drawn() {
                self.window.request_redraw();
            }
        }
        // A script looks again and again whether what it waits for is there.
        let plays = self.script.as_ref().is_some_and(Script::is_going_on);
        let least = if plays { LOOK_AGAIN } else { Duration::MAX };
        let delay = if delay.is_zero() { least } else { delay.min(least) };
        Next::Wait(Instant::now().checked_add(delay.min(Duration::from_secs(3600))))
    }

    fn send_order(&mut self) {
        let order = self.session.order();
        if self.ordered.as_ref() == Some(&order) {
            return;
        }
        if let Some(number) = self.worker.order(order.clone()) {
            self.shown.orders[0] = number;
            self.ordered = Some(order);
        }
    }

    /// The surface is lost: another, and everything that was on its device.
    fn look_again(&mut self) -> Result<(), Failure> {
        self.shown.say("the window's surface was lost; another is made".into());
        self.screen = Screen::default();
        let by_script = self.script.is_some();
        (self.painter, self.context, self.input) =
            look(&self.window, self.adapter.as_deref(), by_script, &self.proxy)?;
        self.window.request_redraw();
        Ok(())
    }
}

/// What draws into the window, and what listens to it.
fn look(
    window: &Arc<Window>,
    adapter: Option<&str>,
    by_script: bool,
    proxy: &EventLoopProxy<Wake>,
) -> Result<(Painter, egui::Context, egui_winit::State), Failure> {
    let proxy = proxy.clone();
    let painter = Painter::start(Canvas::new(window, adapter)?, move || {
        // A window that is gone needs no waking.
        let _ = proxy.send_event(Wake::Painter);
    })?;
    let context = egui::Context::default();
    context.set_theme(egui::Theme::Dark);
    if by_script {
        // Scripts find controls by name.
        context.enable_accesskit();
    }
    let scale = Some(window.scale_factor() as f32);
    let most = Some(painter.largest_side());
    let input =
        egui_winit::State::new(context.clone(), ViewportId::ROOT, window, scale, window.theme(), most);
    Ok((painter, context, input))
}
