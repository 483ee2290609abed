use super::*;

const SCENE: Scene = Scene::new(160, 96);

fn frame(index: u64, obstacle: bool) -> Vec<f32> {
    let mut image = vec![f32::NAN; SCENE.len()];
    SCENE.draw(index, obstacle, &mut image).expect("the buffer has the scene's length");
    image
}

#[test]
fn a_frame_is_a_function_of_its_index_and_of_the_obstacle() {
    assert_eq!(frame(3, true), frame(3, true));
    assert_ne!(frame(3, true), frame(4, true));
    assert_ne!(frame(3, true), frame(3, false));
    assert!(frame(3, true).iter().all(|value| (0.0..=1.0).contains(value)));
}

#[test]
fn the_car_covers_a_part_of_the_road_and_moves() {
    let changed = |index| {
        let (with, without) = (frame(index, true), frame(index, false));
        with.iter().zip(&without).filter(|(a, b)| a != b).count()
    };
    let (far, near) = (changed(0), changed(32));
    assert!(far > SCENE.len() / 200, "{far} values");
    assert!(near > 2 * far && near < SCENE.len() / 4, "{near} values");
}

#[test]
fn every_size_draws_and_a_wrong_buffer_is_refused() {
    for (width, height) in [(0, 0), (1, 1), (1, 50), (3, 2), (50, 1), (640, 480)] {
        let scene = Scene::new(width, height);
        for index in [0, 31, u64::MAX] {
            scene.draw(index, true, &mut vec![0.0; scene.len()]).expect("the buffer has the scene's length");
        }
    }
    assert!(matches!(
        SCENE.draw(0, false, &mut [0.0; 7]),
        Err(BodyError::Buffer { buffer: "image", expected: 46_080, found: 7 })
    ));
}
