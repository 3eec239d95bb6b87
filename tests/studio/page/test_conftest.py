import time
import henkei as hk
def test_mesh(page, tmp_path):
    t=[time.time()]
    def lap(n): t.append(time.time()); print(n, round(t[-1]-t[-2],2))
    page.open_tab("Deform"); lap("tab")
    sheet = hk.shapes.bracket(); lap("make")
    page.open_mesh(sheet, tmp_path / "bracket.obj"); lap("open")
    page.camera(); lap("cam")
    page.settle(); lap("settle")
    page.open_tab("Combine"); lap("tab")
    page.load(); lap("reload")
