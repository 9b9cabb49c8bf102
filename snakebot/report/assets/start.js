Page.start();
document.documentElement.dataset.ready = "yes";
